// Scattering models agree with themselves: samples follow the density (χ² over the
// sphere), sampled albedo equals albedo by quadrature, and no model gains energy.
#include "support/bsdf_lanes.h"
#include "support/test.h"

#ifdef REFRAME_SANITIZED
#define SAMPLES 20000
#define SUB 12
#define FURNACE_SIDE 48
#else
#define SAMPLES 300000
#define SUB 40
#define FURNACE_SIDE 160
#endif

static const double s_pi = 3.14159265358979323846;

// ---- χ² and albedo ----------------------------------------------------------

#define T_BINS 24
#define PHI_BINS 32
#define BINS ( T_BINS * PHI_BINS + 1 ) // the last: below the surface

// Bins over t and v in [0, 1), of equal probability nowhere but fine where the
// lobe is. About the mirror direction: 1 − cos θ = 2 t^k and φ = 2πv; for sharp
// lobes. About the normal, upper hemisphere only, φ from the mirror azimuth:
// cos θ = (1 − t)^k and φ = π (2v − 1)^p; for wide lobes and for grazing eyes,
// whose lobes are much narrower in φ than in θ. Over facets, for a lobe of GGX alone: those of the hemisphere that alpha stretches to
// the facets, each of which mirrors the eye. There the visible ones are spread smoothly, at any roughness along t and b.
typedef struct Grid
{
    RfVec3 axis, t, b;
    double k, p;
    bool about_normal, over_facets;
    double eye[3], alpha[2]; // along t, b and n; along t and b
} Grid;

typedef struct Tally
{
    double expected[BINS]; // probability
    double observed[BINS]; // samples
    double quadrature_albedo, albedo, albedo_error;
} Tally;

static bool has_facets( RfBsdfKind kind )
{
    return kind == RF_BSDF_ANISOTROPIC || kind == RF_BSDF_IRIDESCENT || kind == RF_BSDF_LAYERED;
}

static double dot( RfVec3 a, RfVec3 b ) { return (double)a.x * b.x + (double)a.y * b.y + (double)a.z * b.z; }

// put_surface has been called.
static Grid facet_grid( const Material* m, RfVec3 n, RfVec3 wo )
{
    double stretch = m->kind == RF_BSDF_IRIDESCENT ? 0.0 : (double)m->anisotropy * m->anisotropy, alpha = (double)m->shape;
    Grid grid = { .axis = n, .t = get( TANGENT, 0 ), .k = 3.0, .p = 1.0, .about_normal = true, .over_facets = true };
    grid.b = rf_cross( n, grid.t );
    grid.alpha[0] = alpha + ( 1.0 - alpha ) * stretch;
    grid.alpha[1] = alpha;
    double x = dot( wo, grid.t ), y = dot( wo, grid.b ), z = fmax( dot( wo, n ), (double)RF_MIN_COS );
    double length = sqrt( x * x + y * y + z * z );
    grid.eye[0] = x / length;
    grid.eye[1] = y / length;
    grid.eye[2] = z / length;
    return grid;
}

static Grid make_grid( const Material* m, RfVec3 n, RfVec3 wo )
{
    bool is_phong = m->kind == RF_BSDF_PHONG;
    bool is_frosted = m->kind == RF_BSDF_FROSTED, through = m->side == -1.0f, refracts = is_frosted && through && m->ior > 0.0f;
    bool is_ggx = m->kind == RF_BSDF_GGX || m->kind == RF_BSDF_COATED || is_frosted || has_facets( m->kind );
    if ( has_facets( m->kind ) && rf_max_component( m->diffuse ) == 0.0f && m->clearcoat == 0.0f && m->sheen.x == 0.0f )
        return facet_grid( m, n, wo );
    double lobe = is_phong ? 2.0 / ( m->shape + 1.0 ) : is_ggx ? 2.0 * (double)m->shape * m->shape : 2.0;
    double cos_o = through ? 1.0 : (double)rf_dot( n, wo ); // Lambert's lobe, on the other side
    double ior = refracts ? (double)m->ior : 1.0;
    cos_o = is_frosted && through && !refracts ? -(double)rf_dot( n, wo ) : cos_o;
    lobe *= refracts ? ( 1.0 - 1.0 / ior ) * ( 1.0 - 1.0 / ior ) : 1.0;
    RfVec3 across = rf_madd( wo, n, -rf_dot( n, wo ) );
    Grid grid = { .axis = n, .k = 1.0, .p = 1.0 };
    grid.about_normal = ( lobe > 0.015 && !refracts ) || cos_o < 0.1;
    if ( !grid.about_normal )
    {
        double cosine = fmax( -(double)rf_dot( n, wo ), 0.0 ), sine = sqrt( 1.0 - cosine * cosine ) / ior;
        grid.axis = rf_normalize( rf_sub( rf_scale( n, 2.0f * rf_dot( n, wo ) ), wo ) );
        if ( is_frosted && through )
        {
            across = sine > 0.0 ? rf_normalize( across ) : across;
            grid.axis = rf_normalize( rf_madd( rf_scale( across, (float)-sine ), n, (float)sqrt( 1.0 - sine * sine ) ) );
        }
        grid.k = log2( 2.0 / lobe );
        rf_basis( grid.axis, &grid.t, &grid.b );
        return grid;
    }
    rf_basis( n, &grid.t, &grid.b );
    if ( cos_o < 0.1 )
    {
        double width = sqrt( lobe ) * ( is_ggx ? fmax( cos_o, sqrt( lobe ) ) : 1.0 );
        grid.k = 3.0;
        grid.p = fmin( fmax( log( width / 3.14 ) / log( 0.3 ), 1.0 ), 9.0 );
        grid.t = rf_normalize( rf_scale( across, -1.0f ) );
        grid.b = rf_cross( n, grid.t );
    }
    return grid;
}

// cos θ, 1 − cos θ and the length of dω/dt at t; φ and dφ/dv at v.
static void warp_t( const Grid* grid, double t, double* cos_theta, double* one_minus, double* slope )
{
    double k = grid->k;
    *slope = grid->about_normal ? k * pow( 1.0 - t, k - 1.0 ) : 2.0 * k * pow( t, k - 1.0 );
    *one_minus = grid->about_normal ? 1.0 - pow( 1.0 - t, k ) : 2.0 * pow( t, k );
    *cos_theta = grid->about_normal ? pow( 1.0 - t, k ) : 1.0 - *one_minus;
}

static void warp_v( const Grid* grid, double v, double* phi, double* slope )
{
    double x = 2.0 * v - 1.0;
    *phi = s_pi * copysign( pow( fabs( x ), grid->p ), x );
    *slope = 2.0 * s_pi * grid->p * pow( fabs( x ), grid->p - 1.0 );
}

// At an azimuth of π x.
static int bin_at( const Grid* grid, double t, double x )
{
    double v = 0.5 + 0.5 * copysign( pow( fabs( x ), 1.0 / grid->p ), x );
    int row = (int)fmin( fmax( t, 0.0 ) * T_BINS, T_BINS - 1 );
    return row * PHI_BINS + (int)fmin( v * PHI_BINS, PHI_BINS - 1 );
}

// Where the facet at m, stretched, mirrors the eye to: along t, b and n. Returns its solid angle over that of m.
static double mirror_at( const Grid* grid, const double m[3], double w[3] )
{
    double h[3] = { grid->alpha[0] * m[0], grid->alpha[1] * m[1], m[2] };
    double length = sqrt( h[0] * h[0] + h[1] * h[1] + h[2] * h[2] ), along = 0.0;
    for ( int c = 0; c < 3; ++c )
        along += h[c] / length * grid->eye[c];
    for ( int c = 0; c < 3; ++c )
        w[c] = 2.0 * along * h[c] / length - grid->eye[c];
    return 4.0 * fmax( along, 0.0 ) * grid->alpha[0] * grid->alpha[1] / ( length * length * length );
}

static int find_facet_bin( const Grid* grid, RfVec3 w )
{
    double x = ( dot( w, grid->t ) + grid->eye[0] ) / grid->alpha[0], y = ( dot( w, grid->b ) + grid->eye[1] ) / grid->alpha[1];
    double z = dot( w, grid->axis ) + grid->eye[2];
    return bin_at( grid, 1.0 - cbrt( z / sqrt( x * x + y * y + z * z ) ), atan2( y, x ) / s_pi );
}

static int find_bin( const Grid* grid, RfVec3 w )
{
    if ( grid->over_facets )
        return find_facet_bin( grid, w );
    RfVec3 chord = rf_sub( w, grid->axis );
    double t = grid->about_normal ? 1.0 - pow( fmax( (double)rf_dot( w, grid->axis ), 0.0 ), 1.0 / grid->k )
                                  : pow( 0.25 * (double)rf_dot( chord, chord ), 1.0 / grid->k );
    return bin_at( grid, t, atan2( (double)rf_dot( w, grid->b ), (double)rf_dot( w, grid->t ) ) / s_pi );
}

// Adds one row of the quadrature: all directions of one t.
static void integrate_row( const Material* m, const Grid* grid, RfVec3 n, int row, Tally* tally )
{
    enum
    {
        COLUMNS = PHI_BINS * SUB,
        ROWS = T_BINS * SUB
    };
    static double sines[COLUMNS], cosines[COLUMNS], slopes[COLUMNS], scale[BATCH];
    for ( int c = 0; row == 0 && c < COLUMNS; ++c )
    {
        double phi;
        warp_v( grid, ( c + 0.5 ) / COLUMNS, &phi, slopes + c );
        sines[c] = sin( phi );
        cosines[c] = cos( phi );
    }
    double d, cos_theta, slope;
    warp_t( grid, ( row + 0.5 ) / ROWS, &cos_theta, &d, &slope );
    double s = sqrt( d * ( 1.0 + cos_theta ) );
    for ( int first = 0; first < COLUMNS; first += BATCH )
    {
        int count = COLUMNS - first < BATCH ? COLUMNS - first : BATCH;
        for ( int i = 0; i < count; ++i )
        {
            double at[3] = { s * cosines[first + i], s * sines[first + i], cos_theta }, w[3];
            scale[i] = grid->over_facets ? mirror_at( grid, at, w ) : 1.0;
            const double* to = grid->over_facets ? w : at;
            RfVec3 across = rf_madd( rf_scale( grid->t, (float)to[0] ), grid->b, (float)to[1] );
            put( WI, i, rf_madd( across, grid->axis, (float)to[2] ) );
        }
        evaluate_range( m->kind, 0, count );
        for ( int i = 0; i < count; ++i )
        {
            double solid_angle = slope / ROWS * slopes[first + i] / COLUMNS * scale[i];
            tally->expected[row / SUB * PHI_BINS + ( first + i ) / SUB] += solid_angle * s_lanes[PDF][i];
            double cos_i = fmax( (double)rf_dot( n, get( WI, i ) ), 0.0 );
            tally->quadrature_albedo += solid_angle * cos_i * s_lanes[F + 1][i];
        }
    }
}

static void draw_samples( const Material* m, const Grid* grid, RfVec3 n, uint32_t stream, Tally* tally )
{
    double sum = 0.0, squares = 0.0;
    for ( int first = 0; first < SAMPLES; first += BATCH )
    {
        for ( int i = 0; i < BATCH; ++i )
        {
            for ( int k = 0; k < 3; ++k )
                s_lanes[U + k][i] = uniform( stream, first + i, (uint32_t)k );
        }
        sample_range( m->kind, 0, BATCH );
        evaluate_range( m->kind, 0, BATCH );
        for ( int i = 0; i < BATCH; ++i )
        {
            RfVec3 w = get( WI, i );
            float cos_i = rf_dot( n, w );
            tally->observed[cos_i > 0.0f ? find_bin( grid, w ) : BINS - 1] += 1.0;
            if ( cos_i <= 0.0f )
                continue;
            assert_true( s_lanes[PDF][i] > 0.0f );
            double weight = (double)s_lanes[F + 1][i] * cos_i / s_lanes[PDF][i];
            sum += weight;
            squares += weight * weight;
        }
    }
    tally->albedo = sum / SAMPLES;
    tally->albedo_error = sqrt( fmax( squares / SAMPLES - tally->albedo * tally->albedo, 0.0 ) / SAMPLES );
}

// The chance of a χ² this large or larger (Wilson, Hilferty 1931).
static double chi_squared_tail( double statistic, int freedom )
{
    double v = 2.0 / ( 9.0 * freedom );
    return 0.5 * erfc( ( cbrt( statistic / freedom ) - 1.0 + v ) / sqrt( 2.0 * v ) );
}

static double chi_squared_chance( const Tally* tally )
{
    double statistic = 0.0, pool_expected = 0.0, pool_observed = 0.0;
    int cells = 0;
    for ( int i = 0; i < BINS; ++i )
    {
        pool_expected += SAMPLES * tally->expected[i];
        pool_observed += tally->observed[i];
        if ( pool_expected < 5.0 )
            continue;
        statistic += ( pool_observed - pool_expected ) * ( pool_observed - pool_expected ) / pool_expected;
        pool_expected = pool_observed = 0.0;
        ++cells;
    }
    // What is left over counts as one more, small cell.
    statistic += ( pool_observed - pool_expected ) * ( pool_observed - pool_expected ) / ( pool_expected + 1.0 );
    return chi_squared_tail( statistic, cells - 1 );
}

static bool sampling_agrees( const Material* m, float cos_o, uint32_t stream, double significance )
{
    static Tally tally;
    memset( &tally, 0, sizeof( tally ) );
    RfVec3 n = uniform_direction( stream, 0, 30 );
    RfVec3 wo = view_direction( n, m->side == -1.0f ? -cos_o : cos_o );
    put_surface( m, n, wo );
    Grid grid = make_grid( m, n, wo );
    for ( int row = 0; row < T_BINS * SUB; ++row )
        integrate_row( m, &grid, n, row, &tally );
    double total = 0.0;
    for ( int i = 0; i < BINS - 1; ++i )
        total += tally.expected[i];
    tally.expected[BINS - 1] = fmax( 1.0 - total, 0.0 );
    draw_samples( m, &grid, n, stream, &tally );

    double chance = chi_squared_chance( &tally );
    double gap = fabs( tally.albedo - tally.quadrature_albedo );
    bool passed = chance > significance && total < 1.0 + 1e-3 && gap <= 4.5 * tally.albedo_error + 1e-3 * tally.quadrature_albedo;
    if ( !passed )
        print_message( "kind %d shape %g anisotropy %g film %g diffuse %g specular %g cos %g: p %.3g, pdf integral %.6f, below "
                       "%.0f, albedo %.6f +- %.6f by sampling, %.6f by quadrature\n",
                       m->kind, m->shape, m->anisotropy, m->film, m->diffuse.y, m->specular.y, cos_o, chance, total,
                       tally.observed[BINS - 1], tally.albedo, tally.albedo_error, tally.quadrature_albedo );
    return passed;
}

static void check_sampling( const Material* materials, int count )
{
    const float cosines[] = { 1.0f, 0.7f, 0.2f, 0.02f, -0.3f };
    // Šidák: 0.01 for all cases of all models together.
    double significance = 1.0 - pow( 0.99, 1.0 / 300.0 );
    int failed = 0;
    for ( int i = 0; i < count; ++i )
    {
        // Not the sharpest GGX from the horizon: that lobe is 2 μ α = 2e-6 wide, and
        // the 6e-8 between the floats of a direction show up as some percent of
        // the density, in whatever way it is computed.
        bool is_beyond_float = materials[i].kind != RF_BSDF_PHONG && materials[i].shape == RF_MIN_ALPHA;
        for ( int k = 0; k < ( is_beyond_float ? 4 : 5 ); ++k )
        {
            uint32_t stream = 100u * (uint32_t)materials[i].kind + 10u * (uint32_t)( i + 10 ) + (uint32_t)k;
            failed += !sampling_agrees( materials + i, cosines[k], stream, significance );
        }
    }
    assert_int_equal( failed, 0 );
}

TEST( test_lambert_samples_follow_density )
{
    const Material m = { .kind = RF_BSDF_LAMBERT, .diffuse = { 0.3f, 0.5f, 0.7f } };
    check_sampling( &m, 1 );
}

TEST( test_phong_samples_follow_density )
{
    const Material m[] = {
        { .kind = RF_BSDF_PHONG, .diffuse = { 0.2f, 0.5f, 0.7f }, .specular = { 0.1f, 0.2f, 0.3f }, .shape = 1.0f },
        { .kind = RF_BSDF_PHONG, .specular = GREY( 1 ) },
        { .kind = RF_BSDF_PHONG, .diffuse = GREY( 0.3f ), .specular = GREY( 0.6f ), .shape = 20.0f },
        { .kind = RF_BSDF_PHONG, .specular = GREY( 0.9f ), .shape = 200.0f },
        { .kind = RF_BSDF_PHONG, .diffuse = GREY( 0.2f ), .specular = GREY( 0.7f ), .shape = 5000.0f },
        { .kind = RF_BSDF_PHONG, .diffuse = GREY( 0.1f ), .specular = GREY( 0.8f ), .shape = 1e6f },
        { .kind = RF_BSDF_PHONG, .shape = 10.0f }
    };
    check_sampling( m, 7 );
}

TEST( test_ggx_samples_follow_density )
{
    const Material m[] = {
        { .kind = RF_BSDF_GGX, .diffuse = { 0.2f, 0.5f, 0.8f }, .specular = GREY( 0.04f ), .shape = 1.0f, COAT( 0.04f ) },
        { .kind = RF_BSDF_GGX, .specular = { 1.0f, 0.8f, 0.3f }, .shape = 0.5f, COAT( 0.04f ) },
        { .kind = RF_BSDF_GGX, .diffuse = GREY( 0.8f ), .specular = GREY( 0.04f ), .shape = 0.1f, COAT( 0.04f ) },
        { .kind = RF_BSDF_GGX, .specular = GREY( 0.9f ), .shape = 0.03f, COAT( 0.04f ) },
        { .kind = RF_BSDF_GGX, .diffuse = GREY( 0.5f ), .specular = GREY( 0.5f ), .shape = 0.01f, COAT( 0.04f ) },
        { .kind = RF_BSDF_GGX, .diffuse = GREY( 0.8f ), .specular = GREY( 0.17f ), .shape = RF_MIN_ALPHA, COAT( 0.17f ) },
        { .kind = RF_BSDF_GGX, .shape = 0.3f }
    };
    check_sampling( m, 7 );
}

// ---- Energy -----------------------------------------------------------------

// The brightest channel's directional albedo by stratified sampling, whose weights stay small at any
// roughness; that sampling and density agree is tested above.
static double furnace_albedo( const Material* m, float cos_o )
{
    RfVec3 n = uniform_direction( 5, 0, 0 );
    put_surface( m, n, view_direction( n, m->side == -1.0f ? -cos_o : cos_o ) );
    const int side = FURNACE_SIDE, total = side * side;
    double sum[3] = { 0 };
    for ( int first = 0; first < total; first += BATCH )
    {
        int count = total - first < BATCH ? total - first : BATCH;
        for ( int i = 0; i < count; ++i )
        {
            int k = first + i;
            double third = k * 0.6180339887498949; // the lobe: golden-ratio steps
            s_lanes[U][i] = ( (float)( k / side ) + uniform( 6, k, 0 ) ) / (float)side;
            s_lanes[U + 1][i] = ( (float)( k % side ) + uniform( 6, k, 1 ) ) / (float)side;
            s_lanes[U + 2][i] = rf_minf( (float)( third - floor( third ) ), 1.0f - 0x1p-24f );
            s_lanes[U][i] = rf_minf( s_lanes[U][i], 1.0f - 0x1p-24f );
        }
        sample_range( m->kind, 0, count );
        evaluate_range( m->kind, 0, count );
        for ( int i = 0; i < count; ++i )
        {
            double weight = s_lanes[PDF][i] > 0.0f ? (double)rf_dot( n, get( WI, i ) ) / s_lanes[PDF][i] : 0.0;
            for ( int c = 0; c < 3; ++c )
                sum[c] += weight * s_lanes[F + c][i];
        }
    }
    return fmax( fmax( sum[0], sum[1] ), sum[2] ) / total;
}

static const float s_furnace_cosines[] = { 1.0f, 0.9f, 0.7f, 0.5f, 0.3f, 0.1f, 0.03f, 0.003f };

static void check_furnace( const Material* m, double* least, double* most )
{
    for ( int k = 0; k < 8; ++k )
    {
        double albedo = furnace_albedo( m, s_furnace_cosines[k] );
        if ( !( albedo <= 1.005 ) )
            fail_msg( "albedo %.5f: kind %d shape %g diffuse %g specular %g coat %g cos %g", albedo, m->kind, m->shape,
                      m->diffuse.x, m->specular.x, m->coat_f0, s_furnace_cosines[k] );
        *least = fmin( *least, albedo );
        *most = fmax( *most, albedo );
    }
}

TEST( test_ggx_keeps_energy )
{
    const float alphas[] = { RF_MIN_ALPHA, 0.01f, 0.05f, 0.1f, 0.2f, 0.4f, 0.7f, 1.0f };
    const float coats[] = { 0.0f, 0.04f, 0.17f }, metals[] = { 0.0f, 0.5f, 1.0f };
    for ( int j = 0; j < 9; ++j )
    {
        float coat = coats[j / 3], metallic = metals[j % 3];
        double least = 2.0, most = 0.0;
        for ( int i = 0; i < 8; ++i )
        {
            Material m = { .kind = RF_BSDF_GGX,
                           .diffuse = grey( 1.0f - metallic ),
                           .specular = grey( ( 1.0f - metallic ) * coat + metallic ),
                           .shape = alphas[i],
                           COAT( coat ) };
            check_furnace( &m, &least, &most );
        }
        print_message( "GGX coat %.2f metallic %.1f: albedo %.4f to %.4f\n", coat, metallic, least, most );
    }
}

static const Material s_coated[] = {
    { .kind = RF_BSDF_COATED,
      .diffuse = { 0.2f, 0.5f, 0.8f },
      .specular = GREY( 0.04f ),
      .shape = 0.5f,
      COAT( 0.04f ),
      CLEARCOAT_OF( 1.0f, 0.3f ) },
    { .kind = RF_BSDF_COATED, .specular = { 0.9f, 0.7f, 0.3f }, .shape = 0.3f, COAT( 0.04f ), CLEARCOAT_OF( 0.5f, 0.2f ) },
    { .kind = RF_BSDF_COATED, .shape = 0.2f, CLEARCOAT_OF( 1.0f, 0.2f ) }
};

TEST( test_coated_samples_follow_density ) { check_sampling( s_coated, 3 ); }

// Coats that lean away from what they cover.
TEST( test_leaning_coat_samples_follow_density )
{
    s_coat_lean = rf_vec3( 0.4f, -0.1f, 0.2f );
    check_sampling( s_coated, 2 );
    double least = 2.0, most = 0.0;
    for ( int k = 0; k < 3; ++k )
    {
        Material white = { .kind = RF_BSDF_COATED,
                           .diffuse = grey( 1.0f ),
                           .specular = grey( 0.04f ),
                           .shape = 0.4f,
                           COAT( 0.04f ),
                           CLEARCOAT_OF( 1.0f, 0.05f + 0.3f * (float)k ) };
        s_coat_lean = rf_vec3( 0.1f, 0.3f * (float)k, -0.2f );
        check_furnace( &white, &least, &most );
    }
    s_coat_lean = rf_vec3( 0, 0, 0 );
    print_message( "leaning coat: albedo %.4f to %.4f\n", least, most );
}

TEST( test_coats_keep_energy )
{
    const float alphas[] = { RF_MIN_ALPHA, 0.05f, 0.2f, 1.0f };
    for ( int j = 0; j < 4; ++j )
    {
        double least = 2.0, most = 0.0;
        for ( int i = 0; i < 4; ++i )
        {
            Material m = { .kind = RF_BSDF_COATED,
                           .diffuse = grey( j < 2 ? 1.0f : 0.0f ),
                           .specular = grey( j < 2 ? 0.04f : 1.0f ),
                           .shape = alphas[i],
                           COAT( 0.04f ),
                           CLEARCOAT_OF( j % 2 == 0 ? 1.0f : 0.5f, alphas[3 - i] ) };
            check_furnace( &m, &least, &most );
        }
        print_message( "coated %s, clearcoat %g: albedo %.4f to %.4f\n", j < 2 ? "plastic" : "metal", j % 2 == 0 ? 1.0 : 0.5,
                       least, most );
    }
}

TEST( test_sheen_samples_follow_density )
{
    const Material cloth = { .kind = RF_BSDF_SHEEN, .diffuse = { 0.2f, 0.5f, 0.8f }, .specular = grey( 0.04f ), COAT( 0.04f ) };
    Material m[] = { cloth, cloth, cloth, cloth, cloth };
    const float shapes[] = { 0.5f, 1.0f, 0.3f, 0.5f, 0.2f }, alphas[] = { 0.25f, 1.0f, 0.0f, 0.04f, 0.5f };
    for ( int i = 0; i < 5; ++i )
    {
        m[i].shape = shapes[i];
        m[i].sheen_alpha = alphas[i];
        m[i].sheen = rf_vec3( 0.9f, 1.0f, 0.3f );
    }
    m[4].diffuse = m[4].specular = grey( 0.0f ); // sheen over black
    m[4].coat_f0 = m[4].f90 = 0.0f;
    check_sampling( m, 5 );
}

// White, over white cloth and white metal. Where the model says what the base reflects, that is all of the rest.
TEST( test_sheen_keeps_energy )
{
    const float alphas[] = { 0.0f, 0.01f, 0.04f, 0.1f, 0.3f, 0.6f, 1.0f }, colours[] = { 1.0f, 0.5f };
    for ( int j = 0; j < 4; ++j )
    {
        double least = 2.0, most = 0.0;
        for ( int i = 0; i < 7; ++i )
        {
            Material m = { .kind = RF_BSDF_SHEEN, .shape = j < 2 ? 1.0f : 0.1f, .sheen = grey( colours[j % 2] ) };
            m.diffuse = grey( j < 2 ? 1.0f : 0.0f );
            m.specular = grey( j < 2 ? 0.0f : 1.0f );
            m.f90 = j < 2 ? 0.0f : 1.0f;
            m.sheen_alpha = alphas[i];
            check_furnace( &m, &least, &most );
        }
        print_message( "sheen %g over %s: albedo %.4f to %.4f\n", (double)colours[j % 2], j < 2 ? "cloth" : "metal", least,
                       most );
        assert_true( least > 0.75 );
    }
}

TEST( test_translucent_samples_follow_density )
{
    Material m[4] = { { .kind = RF_BSDF_TRANSLUCENT,
                        .diffuse = { 0.4f, 0.2f, 0.1f },
                        .through = { 0.1f, 0.6f, 0.5f },
                        .specular = GREY( 0.04f ),
                        .shape = 0.2f,
                        COAT( 0.04f ) } };
    m[1] = m[2] = m[0];
    m[1].side = -1.0f;
    m[2].diffuse = grey( 0.0f ); // all of it goes through
    m[2].shape = 0.5f;
    m[3] = m[2];
    m[3].side = -1.0f;
    check_sampling( m, 4 );
}

// What goes to both sides together, from the energies of the sides that are drawn.
TEST( test_translucent_keeps_energy )
{
    const float alphas[] = { RF_MIN_ALPHA, 0.05f, 0.2f, 0.5f, 1.0f }, coats[] = { 0.0f, 0.04f, 0.17f };
    double least = 2.0, most = 0.0;
    for ( int j = 0; j < 15; ++j )
    {
        float coat = coats[j % 3];
        for ( int i = 0; i < 5; ++i )
        {
            float through = 0.25f * (float)i;
            Material m = { .kind = RF_BSDF_TRANSLUCENT,
                           .diffuse = grey( 1.0f - through ),
                           .through = grey( through ),
                           .specular = grey( coat ),
                           .shape = alphas[j / 3],
                           .f90 = coat > 0.0f,
                           .coat_f0 = coat,
                           .coat_f90 = coat > 0.0f };
            double p = (double)rf_through_probability( m.through, m.diffuse, m.specular, m.f90 );
            Material there = m;
            there.side = -1.0f;
            for ( int k = 0; k < 8; ++k )
            {
                double albedo =
                    ( 1.0 - p ) * furnace_albedo( &m, s_furnace_cosines[k] ) + p * furnace_albedo( &there, s_furnace_cosines[k] );
                least = coat > 0.0f ? least : fmin( least, albedo );
                most = fmax( most, albedo );
            }
        }
    }
    print_message( "translucent: albedo %.4f, without a coat %.4f at least\n", most, least );
    assert_true( most <= 1.005 && least > 0.999 );
}

TEST( test_frosted_samples_follow_density )
{
    Material m[8];
    for ( int i = 0; i < 8; ++i )
    {
        m[i] = ( Material ){ .kind = RF_BSDF_FROSTED,
                             .through = { 0.9f, 0.7f, 0.5f },
                             .shape = i % 4 < 2 ? 0.06f : 0.4f,
                             .ior = i < 4 ? 1.5f : -1.5f, // a body or a wall
                             .side = i % 2 == 0 ? 1.0f : -1.0f };
    }
    m[0].ior = m[1].ior = RF_FROSTED_IOR;
    m[2].diffuse = m[6].diffuse = rf_vec3( 0.3f, 0.2f, 0.1f ); // over a base
    m[2].coat_f0 = m[6].coat_f0 = 0.5f;
    check_sampling( m, 8 );
}

// A surface of GGX of this roughness: a white metal or plastic.
static Material facets( RfBsdfKind kind, bool metal, float shape )
{
    return ( Material ){ .kind = kind,
                         .diffuse = grey( metal ? 0.0f : 1.0f ),
                         .specular = grey( metal ? 1.0f : 0.04f ),
                         .shape = shape,
                         COAT( 0.04f ),
                         .clearcoat_alpha = 1.0f,
                         .film_ior = 1.4f,
                         .grain = 0.15f };
}

TEST( test_anisotropic_samples_follow_density )
{
    const float shapes[] = { RF_MIN_ALPHA, RF_MIN_ALPHA, RF_MIN_ALPHA, 0.03f, 0.2f, 0.7f, 1.0f, 0.2f, 0.3f };
    const float stretches[] = { 0.0f, 0.1f, 1.0f, 0.5f, 0.8f, 1.0f, 1.0f, 0.9f, 0.4f };
    Material m[9];
    for ( int i = 0; i < 9; ++i )
    {
        m[i] = facets( RF_BSDF_ANISOTROPIC, i < 7, shapes[i] );
        m[i].specular = i < 7 ? rf_vec3( 1.0f, 0.8f, 0.3f ) : m[i].specular;
        m[i].anisotropy = stretches[i];
        m[i].grain = 0.11f * (float)i;
    }
    check_sampling( m, 9 );
}

TEST( test_iridescent_samples_follow_density )
{
    const float shapes[] = { RF_MIN_ALPHA, 0.05f, 0.4f, 0.3f, 0.3f, 0.5f, 0.2f };
    const float strengths[] = { 1.0f, 0.5f, 0.0f, 0.0f, 1.0f, 1.0f, 1.0f };
    const float thicknesses[] = { 400.0f, 2000.0f, 400.0f, 400.0f, 0.0f, 400.0f, 2000.0f };
    Material m[7];
    for ( int i = 0; i < 7; ++i )
    {
        m[i] = facets( RF_BSDF_IRIDESCENT, i < 3, shapes[i] );
        m[i].specular = i < 3 ? rf_vec3( 1.0f, 0.8f, 0.3f ) : m[i].specular;
        m[i].film = strengths[i];
        m[i].film_thickness = thicknesses[i];
    }
    check_sampling( m, 7 );
}

// The layers whose bits are set: coat, sheen, anisotropy, film.
static Material layers( int which, bool metal, float shape )
{
    Material m = facets( RF_BSDF_LAYERED, metal, shape );
    m.clearcoat = which & 1 ? 1.0f : 0.0f;
    m.clearcoat_alpha = which & 1 ? 0.2f : 1.0f;
    m.sheen = which & 2 ? rf_vec3( 0.9f, 1.0f, 0.3f ) : grey( 0.0f );
    m.sheen_alpha = which & 2 ? 0.1f : 1.0f;
    m.anisotropy = which & 4 ? 0.8f : 0.0f;
    m.film = which & 8 ? 1.0f : 0.0f;
    m.film_thickness = which & 8 ? 400.0f : 0.0f;
    return m;
}

TEST( test_layered_samples_follow_density )
{
    Material m[16];
    for ( int i = 0; i < 16; ++i )
        m[i] = layers( i, i % 3 == 1, 0.2f );
    check_sampling( m, 16 );
}

static void check_facets( const Material* m, int count, const char* what )
{
    double least = 2.0, most = 0.0;
    for ( int i = 0; i < count; ++i )
        check_furnace( m + i, &least, &most );
    print_message( "%s: albedo %.4f to %.4f\n", what, least, most );
}

TEST( test_facets_keep_energy )
{
    const float alphas[] = { RF_MIN_ALPHA, 0.05f, 0.2f, 1.0f }, strengths[] = { 0.0f, 0.3f, 1.0f };
    const float thicknesses[] = { 0.0f, 90.0f, 400.0f, 2000.0f };
    Material m[48];
    for ( int metal = 0; metal < 2; ++metal )
    {
        for ( int i = 0; i < 12; ++i )
        {
            m[i] = facets( RF_BSDF_ANISOTROPIC, metal, alphas[i / 3] );
            m[i].anisotropy = strengths[i % 3];
        }
        check_facets( m, 12, metal ? "brushed metal" : "brushed plastic" );
        for ( int i = 0; i < 48; ++i )
        {
            m[i] = facets( RF_BSDF_IRIDESCENT, metal, alphas[i / 12] );
            m[i].film = strengths[i / 4 % 3];
            m[i].film_thickness = thicknesses[i % 4];
            m[i].film_ior = i % 5 == 0 ? 1.0f : i % 5 == 1 ? 2.5f : 1.4f;
        }
        check_facets( m, 48, metal ? "film over metal" : "film over plastic" );
        for ( int i = 0; i < 32; ++i )
            m[i] = layers( i % 16, metal, i < 16 ? 0.1f : 0.5f );
        check_facets( m, 32, metal ? "layers over metal" : "layers over plastic" );
    }
}

TEST( test_phong_keeps_energy )
{
    const float exponents[] = { 0.0f, 1.0f, 5.0f, 50.0f, 1000.0f, 1e6f };
    for ( int j = 0; j < 3; ++j )
    {
        float kd = 0.5f * (float)j;
        double least = 2.0, most = 0.0;
        for ( int i = 0; i < 6; ++i )
        {
            Material m = { .kind = RF_BSDF_PHONG, .diffuse = grey( kd ), .specular = grey( 1.0f - kd ), .shape = exponents[i] };
            check_furnace( &m, &least, &most );
        }
        print_message( "Phong kd %.1f: albedo %.4f to %.4f\n", kd, least, most );
    }
}
