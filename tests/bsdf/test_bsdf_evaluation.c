// Evaluation of the scattering models: closed forms, nothing below the horizon,
// reciprocity, accuracy of sharp lobes, finite results for any input, and the same bits
// for any batch size. Sampling and energy: test_bsdf_sampling.c.
#include "support/bsdf_lanes.h"
#include "support/test.h"

#ifdef REFRAME_SANITIZED
#define FUZZ 40000
#else
#define FUZZ 1000000
#endif

// ---- Closed forms, conventions ------------------------------------------------

static void assert_near( double value, double reference, double relative )
{
    if ( !( fabs( value - reference ) <= relative * fabs( reference ) ) )
        fail_msg( "%.9g instead of %.9g", value, reference );
}

static void evaluate_one( const Material* m, RfVec3 n, RfVec3 wo, RfVec3 wi )
{
    put_material( 0, m );
    put_normal( 0, m, n );
    put( COAT_N, 0, n );
    put( WO, 0, wo );
    put( WI, 0, wi );
    evaluate_range( m->kind, 0, 1 );
}

TEST( test_closed_forms )
{
    RfVec3 n = rf_vec3( 0.0f, 0.6f, 0.8f );
    Material lambert = { .kind = RF_BSDF_LAMBERT, .diffuse = { 0.2f, 0.4f, 0.6f } };
    evaluate_one( &lambert, n, n, rf_vec3( 0.0f, 0.0f, 1.0f ) );
    assert_near( s_lanes[F + 1][0], 0.4 / 3.14159265, 1e-6 );
    assert_near( s_lanes[PDF][0], 0.8 / 3.14159265, 1e-6 );

    Material phong = { .kind = RF_BSDF_PHONG, .diffuse = GREY( 0.3f ), .specular = GREY( 0.5f ), .shape = 50.0f };
    evaluate_one( &phong, n, n, n );
    assert_near( s_lanes[F][0], 0.3 / 3.14159265 + 0.5 * 52.0 / 6.2831853, 1e-6 );
    assert_near( s_lanes[PDF][0], 0.375 / 3.14159265 + 0.625 * 51.0 / 6.2831853, 1e-6 );

    Material ggx = { .kind = RF_BSDF_GGX, .diffuse = GREY( 0.6f ), .specular = GREY( 0.04f ), .shape = 0.3f, COAT( 0.04f ) };
    evaluate_one( &ggx, n, n, n );
    double d = 1.0 / ( 3.14159265 * 0.09 );
    assert_near( s_lanes[F][0], 0.04 * d / 4.0 + 0.6 / 3.14159265 * 0.96 * 0.96, 1e-5 );
    double chance = 0.04 / ( 0.04 + 0.6 * 0.96 );
    assert_near( s_lanes[PDF][0], chance * d / 4.0 + ( 1.0 - chance ) / 3.14159265, 1e-5 );
}

// f and pdf vanish below the surface; an eye below is lifted to the horizon.
TEST( test_nothing_below_the_horizon )
{
    Material materials[] = {
        { .kind = RF_BSDF_LAMBERT, .diffuse = GREY( 1 ) },
        { .kind = RF_BSDF_PHONG, .diffuse = GREY( 0.5f ), .specular = GREY( 0.5f ), .shape = 3.0f },
        { .kind = RF_BSDF_GGX, .diffuse = GREY( 0.5f ), .specular = GREY( 0.5f ), .shape = 0.5f, COAT( 0.04f ) },
        { .kind = RF_BSDF_SHEEN,
          .diffuse = GREY( 0.5f ),
          .specular = GREY( 0.04f ),
          .shape = 0.5f,
          COAT( 0.04f ),
          .sheen = { 0.9f, 0.8f, 0.7f },
          .sheen_alpha = 0.2f }
    };
    for ( size_t k = 0; k < sizeof materials / sizeof *materials; ++k )
    {
        for ( int i = 0; i < 2000; ++i )
        {
            RfVec3 n = uniform_direction( 1, i, 0 ), wo = uniform_direction( 1, i, 2 ), wi = uniform_direction( 1, i, 4 );
            evaluate_one( materials + k, n, wo, wi );
            bool is_lit = rf_dot( n, wi ) > 0.0f;
            assert_true( ( s_lanes[PDF][0] > 0.0f ) == is_lit && ( s_lanes[F][0] > 0.0f ) == is_lit );
            if ( rf_dot( n, wo ) >= 0.0f || !is_lit )
                continue;
            float f = s_lanes[F][0], pdf = s_lanes[PDF][0];
            RfVec3 lifted = rf_normalize( rf_madd( wo, n, RF_MIN_COS - rf_dot( n, wo ) ) );
            evaluate_one( materials + k, n, lifted, wi );
            assert_near( f, s_lanes[F][0], 1e-3 );
            assert_near( pdf, s_lanes[PDF][0], 1e-3 );
        }
    }
}

// D at the sharpest lobe against the same formula in double: nothing cancels.
TEST( test_sharp_lobe_is_accurate )
{
    Material m = { .kind = RF_BSDF_GGX, .specular = GREY( 1 ), .shape = RF_MIN_ALPHA, .f90 = 1 };
    double a2 = (double)RF_MIN_ALPHA * RF_MIN_ALPHA;
    for ( int i = 0; i < 20000; ++i )
    {
        RfVec3 n = rf_vec3( 0.0f, 0.0f, 1.0f );
        RfVec3 wo = view_direction( n, 0.1f + 0.9f * uniform( 2, i, 0 ) );
        float slope = RF_MIN_ALPHA * 10.0f * uniform( 2, i, 1 ), phi = 2.0f * RF_PI * uniform( 2, i, 2 );
        RfVec3 h = rf_normalize( rf_vec3( slope * cosf( phi ), slope * sinf( phi ), 1.0f ) );
        RfVec3 wi = rf_sub( rf_scale( h, 2.0f * rf_dot( wo, h ) ), wo );
        evaluate_one( &m, n, wo, wi );
        double x = (double)wo.x + wi.x, y = (double)wo.y + wi.y, z = (double)wo.z + wi.z;
        double tan2 = ( x * x + y * y ) / ( z * z );
        double d = ( 1.0 + tan2 ) * ( 1.0 + tan2 ) / ( 3.14159265358979 * a2 * pow( 1.0 + tan2 / a2, 2.0 ) );
        double so = sqrt( a2 + ( 1.0 - a2 ) * wo.z * wo.z ), si = sqrt( a2 + ( 1.0 - a2 ) * wi.z * wi.z );
        assert_near( s_lanes[F][0], 0.5 * d / ( wo.z * si + wi.z * so ), 1e-4 );
        assert_near( s_lanes[PDF][0], 0.5 * d / ( wo.z + so ), 1e-4 );
    }
}

static Material random_material( RfBsdfKind kind, uint32_t stream, int i )
{
    float pick = uniform( stream, i, 20 );
    Material m = { .kind = kind, .f90 = 1, .coat_f90 = 1, CLEARCOAT_OF( 1, RF_MIN_ALPHA ) };
    m.diffuse = rf_vec3( uniform( stream, i, 21 ), uniform( stream, i, 22 ), uniform( stream, i, 23 ) );
    m.specular = rf_vec3( uniform( stream, i, 24 ), uniform( stream, i, 25 ), uniform( stream, i, 26 ) );
    if ( pick > 0.8f )
        m.diffuse = grey( pick > 0.9f ? 1.0f : 0.0f );
    if ( uniform( stream, i, 27 ) > 0.8f )
        m.specular = grey( pick > 0.9f ? 1.0f : 0.0f );
    m.f90 = uniform( stream, i, 28 ) > 0.2f ? 1.0f : 0.0f;
    m.coat_f0 = pick > 0.5f ? 0.04f : 0.0f;
    m.coat_f90 = m.f90;
    float shape = uniform( stream, i, 29 );
    m.clearcoat = uniform( stream, i, 30 ) > 0.3f ? 1.0f : uniform( stream, i, 30 );
    m.clearcoat_alpha = rf_maxf( RF_MIN_ALPHA, uniform( stream, i, 31 ) );
    m.sheen = rf_vec3( uniform( stream, i, 32 ), uniform( stream, i, 33 ), uniform( stream, i, 34 ) );
    if ( uniform( stream, i, 35 ) > 0.8f )
        m.sheen = grey( uniform( stream, i, 35 ) > 0.9f ? 1.0f : 0.0f );
    m.sheen_alpha = uniform( stream, i, 36 ) > 0.9f ? 1.0f : uniform( stream, i, 37 ) * uniform( stream, i, 37 );
    m.anisotropy = uniform( stream, i, 38 ) > 0.8f ? 1.0f : uniform( stream, i, 39 );
    m.grain = uniform( stream, i, 44 );
    m.film = uniform( stream, i, 45 ) > 0.7f ? 1.0f : uniform( stream, i, 45 );
    m.film_ior = 1.0f + uniform( stream, i, 46 );
    m.film_thickness = uniform( stream, i, 47 ) < 0.2f ? 0.0f : 1200.0f * uniform( stream, i, 48 );
    m.through = rf_vec3( uniform( stream, i, 90 ), pick > 0.7f ? 0.0f : uniform( stream, i, 91 ), pick > 0.8f ? 0.0f : 1.0f );
    m.side = uniform( stream, i, 92 ) < 0.5f ? -1.0f : 1.0f;
    if ( kind == RF_BSDF_PHONG )
        m.shape = pick < 0.1f ? 0.0f : pick > 0.8f ? 1e6f : exp2f( 14.0f * shape );
    else
        m.shape = pick < 0.2f ? RF_MIN_ALPHA : pick > 0.95f ? 1.0f : rf_maxf( RF_MIN_ALPHA, shape * shape );
    if ( kind == RF_BSDF_FROSTED )
    {
        m.shape = rf_maxf( m.shape, RF_FROSTED_ALPHA );
        m.ior = ( uniform( stream, i, 93 ) < 0.5f ? -1.0f : 1.0f ) * ( RF_FROSTED_IOR + uniform( stream, i, 94 ) );
    }
    return m;
}

TEST( test_models_are_reciprocal )
{
    for ( int kind = 0; kind < RF_BSDF_FIRST_SPECULAR; ++kind )
    {
        for ( int i = 0; i < 20000; ++i )
        {
            Material m = random_material( (RfBsdfKind)kind, 3, i );
            m.side = 1.0f; // through the surface: test_translucent.c
            RfVec3 n = uniform_direction( 3, i, 0 ), wo = uniform_direction( 3, i, 2 ), wi = uniform_direction( 3, i, 4 );
            if ( i % 2 == 0 ) // near the mirror direction, where sharp lobes are
            {
                RfVec3 mirror = rf_sub( rf_scale( n, 2.0f * rf_dot( n, wo ) ), wo );
                wi = rf_normalize( rf_madd( mirror, wi, 0.002f ) );
            }
            if ( rf_dot( n, wo ) < RF_MIN_COS || rf_dot( n, wi ) < RF_MIN_COS )
                continue;
            evaluate_one( &m, n, wo, wi );
            RfVec3 f = get( F, 0 );
            evaluate_one( &m, n, wi, wo );
            assert_near( s_lanes[F][0], f.x, 1e-4 );
            assert_near( s_lanes[F + 1][0], f.y, 1e-4 );
            assert_near( s_lanes[F + 2][0], f.z, 1e-4 );
        }
    }
}

// ---- Lanes on their own, and any input ----------------------------------------

// A direction out of those that make trouble: along, against and across n, at
// grazing, or any.
static RfVec3 awkward_direction( RfVec3 n, RfVec3 wo, uint32_t stream, int i, uint32_t dimension )
{
    RfVec3 t, b, any = uniform_direction( stream, i, dimension );
    rf_basis( n, &t, &b );
    float tilt = exp2f( -26.0f * uniform( stream, i, dimension + 3 ) ) * ( i % 2 ? 1.0f : -1.0f );
    RfVec3 mirror = rf_sub( rf_scale( n, 2.0f * rf_dot( n, wo ) ), wo );
    switch ( (int)( 10.0f * uniform( stream, i, dimension + 2 ) ) )
    {
        case 0: return n;
        case 1: return rf_scale( n, -1.0f );
        case 2: return t;
        case 3: return rf_normalize( rf_madd( b, n, tilt ) );
        case 4: return rf_normalize( rf_madd( rf_scale( n, -1.0f ), t, tilt ) );
        case 5: return wo;
        case 6: return rf_scale( wo, -1.0f );
        case 7: return rf_normalize( mirror );
        case 8: return rf_normalize( rf_madd( mirror, any, tilt ) );
        default: return any;
    }
}

static RfVec3 awkward_normal( uint32_t stream, int i )
{
    float pick = uniform( stream, i, 40 );
    RfVec3 any = uniform_direction( stream, i, 41 );
    if ( pick < 0.3f )
        return rf_vec3( pick < 0.1f, pick >= 0.1f && pick < 0.2f, pick >= 0.2f );
    if ( pick < 0.4f )
        return rf_vec3( 0.0f, 0.0f, pick < 0.35f ? -1.0f : -0.0f ).z < 0.0f ? rf_vec3( 0.0f, -0.0f, -1.0f )
                                                                            : rf_vec3( 1.0f, 0.0f, -0.0f );
    return any;
}

// On the side of n, up to next to its horizon.
static RfVec3 awkward_coat_normal( RfVec3 n, uint32_t stream, int i )
{
    RfVec3 leaned = rf_madd( uniform_direction( stream, i, 80 ), n, i % 3 == 1 ? 1.001f : 2.0f );
    return rf_normalize( leaned );
}

static void fill_awkward( RfBsdfKind kind, uint32_t stream, int first )
{
    for ( int i = 0; i < BATCH; ++i )
    {
        int k = first + i;
        Material m = random_material( kind, stream, k );
        put_material( i, &m );
        RfVec3 n = awkward_normal( stream, k ), any = uniform_direction( stream, k, 43 );
        RfVec3 wo = awkward_direction( n, any, stream, k, 50 );
        put_normal( i, &m, n );
        put( COAT_N, i, k % 3 == 0 ? n : awkward_coat_normal( n, stream, k ) );
        put( WO, i, wo );
        put( WI, i, awkward_direction( n, wo, stream, k, 60 ) );
        for ( int c = 0; c < 3; ++c )
        {
            float u = uniform( stream, k, 70u + (uint32_t)c ), end = uniform( stream, k, 73u + (uint32_t)c );
            s_lanes[U + c][i] = end < 0.1f ? 0.0f : end > 0.9f ? 1.0f - 0x1p-24f : u;
        }
    }
}

static void assert_lane_is_sound( int i )
{
    float total = s_lanes[F][i] + s_lanes[F + 1][i] + s_lanes[F + 2][i] + s_lanes[PDF][i];
    bool is_positive = s_lanes[F][i] >= 0.0f && s_lanes[F + 1][i] >= 0.0f && s_lanes[F + 2][i] >= 0.0f && s_lanes[PDF][i] >= 0.0f;
    if ( !isfinite( total ) || !is_positive )
        fail_msg( "f %g %g %g pdf %g: shape %g, n %g %g %g, wo %g %g %g, wi %g %g %g", s_lanes[F][i], s_lanes[F + 1][i],
                  s_lanes[F + 2][i], s_lanes[PDF][i], s_lanes[SHAPE][i], s_lanes[N][i], s_lanes[N + 1][i], s_lanes[N + 2][i],
                  s_lanes[WO][i], s_lanes[WO + 1][i], s_lanes[WO + 2][i], s_lanes[WI][i], s_lanes[WI + 1][i],
                  s_lanes[WI + 2][i] );
}

TEST( test_any_input_is_finite )
{
    for ( int kind = 0; kind < RF_BSDF_FIRST_SPECULAR; ++kind )
    {
        for ( int first = 0; first < FUZZ; first += BATCH )
        {
            fill_awkward( (RfBsdfKind)kind, 8, first );
            evaluate_range( (RfBsdfKind)kind, 0, BATCH );
            for ( int i = 0; i < BATCH; ++i )
                assert_lane_is_sound( i );
            sample_range( (RfBsdfKind)kind, 0, BATCH );
            evaluate_range( (RfBsdfKind)kind, 0, BATCH );
            for ( int i = 0; i < BATCH; ++i )
            {
                assert_lane_is_sound( i );
                float length = rf_length( get( WI, i ) );
                if ( !( fabsf( length - 1.0f ) < 2e-6f ) )
                    fail_msg( "kind %d lane %d: wi has length %.8f", kind, first + i, length );
            }
        }
    }
}

// Any count, any place in the array, any choice of outputs: the same bits.
TEST( test_lanes_stand_alone )
{
    static float whole[ARRAYS][BATCH], sampled[3][BATCH];
    for ( int kind = 0; kind < RF_BSDF_FIRST_SPECULAR; ++kind )
    {
        fill_awkward( (RfBsdfKind)kind, 9, 0 );
        evaluate_range( (RfBsdfKind)kind, 0, BATCH );
        memcpy( whole, s_lanes, sizeof( whole ) );
        for ( int size = 1; size < 14; size += 4 )
        {
            memset( s_lanes[F], 0xff, sizeof( s_lanes[F] ) * 4 );
            for ( int first = 0; first < BATCH; first += size )
                evaluate_range( (RfBsdfKind)kind, first, BATCH - first < size ? BATCH - first : size );
            assert_memory_equal( s_lanes[F], whole[F], sizeof( s_lanes[F] ) * 4 );
        }
        const RfBsdfLanes lanes = parameters_from( (RfBsdfKind)kind, 0 );
        const float* const wo[3] = THREE( WO );
        const float* const wi[3] = THREE( WI );
        float* const f[3] = THREE( F );
        memset( s_lanes[F], 0xff, sizeof( s_lanes[F] ) * 4 );
        rf_bsdf_evaluate( (RfBsdfKind)kind, BATCH, &lanes, wo, wi, f, NULL );
        rf_bsdf_evaluate( (RfBsdfKind)kind, BATCH, &lanes, wo, wi, NULL, s_lanes[PDF] );
        rf_bsdf_evaluate( (RfBsdfKind)kind, BATCH, &lanes, wo, wi, NULL, NULL );
        assert_memory_equal( s_lanes[F], whole[F], sizeof( s_lanes[F] ) * 4 );

        sample_range( (RfBsdfKind)kind, 0, BATCH );
        memcpy( sampled, s_lanes[WI], sizeof( sampled ) );
        for ( int first = 0; first < BATCH; ++first )
            sample_range( (RfBsdfKind)kind, first, 1 );
        assert_memory_equal( s_lanes[WI], sampled, sizeof( sampled ) );
    }
}

// ---- The table of models ------------------------------------------------------

// Hits are sorted by the order of the kinds, which must agree with what the models can do.
TEST( test_kinds_agree_with_the_model_table )
{
    assert_int_equal( RF_BSDF_LAMBERT, 0 );
    assert_int_equal( RF_BSDF_FIRST_GLOSSY, 1 );
    for ( int kind = 0; kind < RF_BSDF_KIND_COUNT; ++kind )
    {
        const RfBsdfModel* model = rf_bsdf_model( (RfBsdfKind)kind );
        assert_true( model->name != NULL && model->evaluate != NULL );
        assert_true( rf_has_param( model->params, RF_PARAM_DIFFUSE ) && (uint64_t)model->params >> RF_PARAM_COUNT == 0 );
        assert_true( ( model->sample != NULL ) == ( kind < RF_BSDF_FIRST_SPECULAR ) );
        assert_true( ( model->sample_weighted != NULL ) == ( kind >= RF_BSDF_FIRST_SPECULAR ) );
    }
}

// Every parameter of a material goes to a place of its own.
TEST( test_parameters_have_places_of_their_own )
{
    RfMaterial m = { .diffuse = { 1, 2, 3 },
                     .specular = { 4, 5, 6 },
                     .alpha = 7,
                     .f90 = 8,
                     .coat_f0 = 9,
                     .coat_f90 = 10,
                     .clearcoat = 11,
                     .clearcoat_alpha = 12,
                     .tint = { 13, 14, 15 },
                     .sheen = { 16, 17, 18 },
                     .sheen_alpha = 19,
                     .anisotropy = 20,
                     .film = 21,
                     .film_ior = 22,
                     .film_thickness = 23,
                     .dispersion = 24 };
    float expected = 1.0f;
    for ( int p = 0; p < RF_PARAM_COUNT; ++p )
    {
        if ( !rf_has_param( RF_PARAMS_OF_HIT, (RfBsdfParam)p ) )
            assert_true( *rf_material_param( &m, (RfBsdfParam)p ) == expected++ );
    }
    assert_true( expected == 25.0f );
}
