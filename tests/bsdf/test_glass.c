// Mirrors and glass: Fresnel's and Snell's laws by hand, energy, and agreement of
// sampling, density and evaluation for rough lobes; channel by channel where glass disperses or has a film.
#include "support/test.h"
#include "bsdf/thin_film.h"

#include "base/random.h"

typedef struct Glass
{
    RfVec3 base, specular, tint;
    float alpha, ior, metal;
    float base_share, bare;
    bool spectral;
    float film, film_ior, film_thickness, dispersion, choice; // if so
} Glass;

typedef struct Drawn
{
    RfVec3 wi, weight;
    float pdf;
} Drawn;

static const RfVec3 s_n = { 0, 0, 1 };

static RfBsdfLanes lanes_of( const Glass* g )
{
    const float* param[RF_PARAM_COUNT] = {
        [RF_PARAM_DIFFUSE] = &g->base.x,
        &g->base.y,
        &g->base.z,
        [RF_PARAM_SPECULAR] = &g->specular.x,
        &g->specular.y,
        &g->specular.z,
        [RF_PARAM_SHAPE] = &g->alpha,
        [RF_PARAM_F90] = &g->metal,
        [RF_PARAM_COAT_F0] = &g->base_share,
        [RF_PARAM_COAT_F90] = &g->bare,
        [RF_PARAM_TINT] = &g->tint.x,
        &g->tint.y,
        &g->tint.z,
        [RF_PARAM_IOR] = &g->ior,
        [RF_PARAM_FILM] = &g->film,
        [RF_PARAM_FILM_IOR] = &g->film_ior,
        [RF_PARAM_FILM_THICKNESS] = &g->film_thickness,
        [RF_PARAM_DISPERSION] = &g->dispersion,
        [RF_PARAM_CHOICE] = &g->choice,
    };
    const float* n[3] = { &s_n.x, &s_n.y, &s_n.z };
    return rf_bsdf_lanes( g->spectral ? RF_BSDF_SPECTRAL : RF_BSDF_GLASS, n, param, 0 );
}

static RfBsdfKind kind_of( const Glass* g ) { return g->spectral ? RF_BSDF_SPECTRAL : RF_BSDF_GLASS; }

static Drawn draw( const Glass* g, RfVec3 wo, const float u[3] )
{
    Drawn d;
    RfBsdfLanes lanes = lanes_of( g );
    const float* o[3] = { &wo.x, &wo.y, &wo.z };
    const float* random[3] = { u, u + 1, u + 2 };
    float* wi[3] = { &d.wi.x, &d.wi.y, &d.wi.z };
    float* weight[3] = { &d.weight.x, &d.weight.y, &d.weight.z };
    rf_bsdf_sample_weighted( kind_of( g ), 1, &lanes, o, random, wi, weight, &d.pdf );
    return d;
}

static RfVec3 evaluate( const Glass* g, RfVec3 wo, RfVec3 wi, float* pdf )
{
    RfBsdfLanes lanes = lanes_of( g );
    const float* o[3] = { &wo.x, &wo.y, &wo.z };
    const float* in[3] = { &wi.x, &wi.y, &wi.z };
    RfVec3 f;
    float* out[3] = { &f.x, &f.y, &f.z };
    rf_bsdf_evaluate( kind_of( g ), 1, &lanes, o, in, out, pdf );
    return f;
}

static RfVec3 tilted( float degrees )
{
    float a = degrees * RF_PI / 180.0f;
    return rf_vec3( sinf( a ), 0, cosf( a ) );
}

static bool near( float a, double b, double tolerance ) { return fabs( (double)a - b ) <= tolerance; }

static const float s_reflect[3] = { 0.3f, 0.6f, 0.0f }, s_pass[3] = { 0.3f, 0.6f, 0.99999f };

TEST( test_snell_and_fresnel )
{
    Glass g = { .tint = { 1, 0.5f, 0.25f }, .ior = 1.5f };
    Drawn d = draw( &g, tilted( 0 ), s_reflect );
    assert_true( near( d.wi.z, 1, 1e-6 ) && d.pdf == RF_DELTA_PDF );
    // chances of the two ways are F and 1 − F, up to the tint
    double f = 0.04, pass = ( 1 - f ) * ( 1 + 0.5 + 0.25 ) / 3, chance = f / ( f + pass );
    assert_true( near( d.weight.x, f / chance, 1e-4 ) );
    d = draw( &g, tilted( 30 ), s_pass );
    double sine = 0.5 / 1.5;
    assert_true( near( d.wi.x, -sine, 1e-5 ) && near( d.wi.z, -sqrt( 1 - sine * sine ), 1e-5 ) && d.pdf == RF_DELTA_PDF );
    assert_true( near( d.weight.y, 0.5 * (double)d.weight.x, 1e-5 ) );
    // at Brewster's angle the reflectance is half that of the perpendicular part
    Glass clear = { .tint = { 1, 1, 1 }, .ior = 1.5f };
    float degrees = atanf( 1.5f ) * 180.0f / RF_PI;
    int reflected = 0;
    for ( int i = 0; i < 100000; ++i )
    {
        float u[3] = { 0.5f, 0.5f, ( (float)i + 0.5f ) / 100000.0f };
        reflected += draw( &clear, tilted( degrees ), u ).wi.z > 0.0f;
    }
    double cos_o = cos( atan( 1.5 ) ), cos_t = sqrt( 1 - ( 1 - cos_o * cos_o ) / 2.25 );
    double s = ( cos_o - 1.5 * cos_t ) / ( cos_o + 1.5 * cos_t );
    assert_true( fabs( reflected / 100000.0 - 0.5 * s * s ) < 2e-5 + 1e-5 );
    // from within, beyond the critical angle of 41.8 degrees, all is reflected
    clear.ior = 1.0f / 1.5f;
    assert_true( draw( &clear, tilted( 42 ), s_pass ).wi.z > 0.0f );
    assert_true( draw( &clear, tilted( 41 ), s_pass ).wi.z < 0.0f );
    // what goes in is squeezed by the square of the index, what comes out spread
    assert_true( near( draw( &clear, tilted( 0 ), s_pass ).weight.x, 2.25, 1e-3 ) );
}

TEST( test_thin_walls_and_mirrors )
{
    Glass wall = { .tint = { 1, 1, 1 }, .ior = -1.5f };
    Drawn d = draw( &wall, tilted( 50 ), s_pass );
    assert_true( near( d.wi.x, -sin( 50 * 3.14159265 / 180 ), 1e-5 ) && near( d.wi.z, -cos( 50 * 3.14159265 / 180 ), 1e-5 ) );
    assert_true( near( d.weight.x, 1, 1e-5 ) );
    Glass mirror = { .specular = { 0.9f, 0.5f, 0.1f } };
    d = draw( &mirror, tilted( 0 ), s_pass );
    assert_true( near( d.wi.z, 1, 1e-6 ) && near( d.weight.x, 0.9, 1e-5 ) && near( d.weight.z, 0.1, 1e-5 ) );
    d = draw( &mirror, tilted( 89.9f ), s_pass );
    assert_true( d.weight.z > 0.98f );
}

static float uniform( int i, uint32_t dimension ) { return rf_random( rf_pixel_key( 5, (uint32_t)i ), dimension ); }

// The channels' indices by KHR_materials_dispersion, on the side from which they are seen.
static double index_of( const Glass* g, int channel )
{
    double central = g->ior < 1.0f ? 1.0 / (double)g->ior : (double)g->ior;
    double n = central + ( channel - 1 ) * ( central - 1.0 ) * 0.025 * (double)g->dispersion;
    return g->ior < 1.0f ? 1.0 / fmax( n, 1.0 ) : fmax( n, 1.0 );
}

// Sampled directions that have a width carry the density that evaluate gives;
// their share is the integral of that density; and no light is made.
static void check_rough( Glass g, float degrees )
{
    enum
    {
        COUNT = 60000,
        GRID = 600
    };
    RfVec3 wo = tilted( degrees );
    double wide = 0.0, albedo = 0.0, wide_albedo = 0.0, wide_albedo2 = 0.0;
    for ( int i = 0; i < COUNT; ++i )
    {
        float u[3] = { uniform( i, 0 ), uniform( i, 1 ), uniform( i, 2 ) };
        Drawn d = draw( &g, wo, u );
        assert_true( d.weight.x >= 0.0f && d.weight.x < 20.0f );
        float n = g.ior > 0.0f && d.wi.z < 0.0f ? (float)index_of( &g, 0 ) : 1.0f, squeeze = n * n; // energy, not radiance
        albedo += (double)( d.weight.x * squeeze ) / COUNT;
        if ( d.pdf == RF_DELTA_PDF )
            continue;
        float pdf;
        RfVec3 f = evaluate( &g, wo, d.wi, &pdf );
        assert_true( fabsf( pdf - d.pdf ) <= 1e-4f * pdf );
        assert_true( fabsf( f.x * d.wi.z - d.weight.x * pdf ) <= 1e-4f * f.x * fabsf( d.wi.z ) + 1e-6f || d.wi.z <= 0.0f );
        wide += 1.0 / COUNT;
        wide_albedo += (double)d.weight.x / COUNT;
        wide_albedo2 += (double)( d.weight.x * d.weight.x ) / COUNT;
    }
    double integral = 0.0, quadrature = 0.0;
    for ( int i = 0; i < GRID * GRID; ++i )
    {
        double z = ( i / GRID + 0.5 ) / GRID, a = ( i % GRID + 0.5 ) / GRID * 2 * 3.14159265358979, r = sqrt( 1 - z * z );
        float pdf;
        RfVec3 wi = rf_vec3( (float)( r * cos( a ) ), (float)( r * sin( a ) ), (float)z );
        RfVec3 f = evaluate( &g, wo, wi, &pdf );
        integral += (double)pdf * 2 * 3.14159265358979 / ( GRID * GRID );
        quadrature += (double)f.x * z * 2 * 3.14159265358979 / ( GRID * GRID );
    }
    double error = sqrt( ( wide_albedo2 - wide_albedo * wide_albedo ) / COUNT );
    assert_true( albedo < 1.0 + 0.01 && albedo > 0.4 );
    assert_true( integral < wide + 0.01 && integral > wide - 0.2 ); // what is drawn below the surface is lost
    assert_true( fabs( quadrature - wide_albedo ) < 4.0 * error + 2e-3 );
}

TEST( test_rough_lobes_agree_with_themselves )
{
    static const float degrees[] = { 0.0f, 35.0f, 70.0f };
    for ( int k = 0; k < 3; ++k )
    {
        check_rough( ( Glass ){ .tint = { 1, 1, 1 }, .alpha = 0.3f, .ior = 1.5f }, degrees[k] );
        check_rough( ( Glass ){ .tint = { 1, 1, 1 }, .alpha = 0.3f, .ior = 1.0f / 1.5f }, degrees[k] );
        check_rough( ( Glass ){ .base = { 0.6f, 0.5f, 0.4f }, .tint = { 0.4f, 0.4f, 0.4f }, .alpha = 0.2f, .ior = -1.5f },
                     degrees[k] );
        check_rough( ( Glass ){ .base = { 0.6f, 0.5f, 0.4f }, .tint = { 0.4f, 0.4f, 0.4f }, .alpha = 0.0f, .ior = 1.4f },
                     degrees[k] );
    }
}

// Half a metal: its part of the reflection is coloured, and light goes through
// the other half alone.
TEST( test_half_a_metal_transmits_the_rest )
{
    Glass g = { .specular = { 0.4f, 0.2f, 0.1f }, .tint = { 0.5f, 0.5f, 0.5f }, .ior = 1.5f, .metal = 0.5f };
    double f = 0.5 * 0.04 + ( 0.4 + 0.2 + 0.1 ) / 3, pass = ( 1 - f ) * 0.5, chance = f / ( f + pass );
    Drawn d = draw( &g, tilted( 0 ), s_reflect );
    assert_true( d.wi.z > 0.0f && near( d.weight.x, ( 0.02 + 0.4 ) / chance, 1e-4 ) &&
                 near( d.weight.z, ( 0.02 + 0.1 ) / chance, 1e-4 ) );
    d = draw( &g, tilted( 0 ), s_pass );
    assert_true( d.wi.z < 0.0f && near( d.weight.x, 0.96 * 0.5 / 2.25 / ( 1 - chance ), 1e-4 ) );
    // at grazing all of it is white
    d = draw( &g, tilted( 89.99f ), s_reflect );
    assert_true( near( d.weight.z / d.weight.x, 1.0, 5e-3 ) );
    Glass all = { .specular = { 0.9f, 0.5f, 0.1f }, .ior = 1.5f, .metal = 1.0f }, mirror = { .specular = { 0.9f, 0.5f, 0.1f } };
    for ( int k = 0; k < 8; ++k )
    {
        Drawn a = draw( &all, tilted( 11.0f * (float)k ), s_pass ), b = draw( &mirror, tilted( 11.0f * (float)k ), s_pass );
        assert_true( near( a.weight.x, (double)b.weight.x, 1e-5 ) && near( a.wi.x, (double)b.wi.x, 1e-6 ) );
    }
    check_rough( ( Glass ){ .base = { 0.3f, 0.3f, 0.3f },
                            .specular = { 0.3f, 0.3f, 0.3f },
                            .tint = { 0.2f, 0.2f, 0.2f },
                            .alpha = 0.3f,
                            .ior = 1.5f,
                            .metal = 0.5f },
                 35.0f );
}

TEST( test_rough_glass_is_reciprocal )
{
    Glass g = { .base = { 0.6f, 0.5f, 0.4f }, .tint = { 0.4f, 0.4f, 0.4f }, .alpha = 0.4f, .ior = 1.5f };
    for ( int i = 0; i < 2000; ++i )
    {
        RfVec3 a = rf_normalize( rf_vec3( uniform( i, 3 ) - 0.5f, uniform( i, 4 ) - 0.5f, 0.05f + uniform( i, 5 ) ) );
        RfVec3 b = rf_normalize( rf_vec3( uniform( i, 6 ) - 0.5f, uniform( i, 7 ) - 0.5f, 0.05f + uniform( i, 8 ) ) );
        float pdf, there = evaluate( &g, a, b, &pdf ).x, back = evaluate( &g, b, a, &pdf ).x;
        assert_true( there > 0.0f && fabsf( there - back ) <= 1e-4f * there );
    }
}

// A white surface that is glass in part reflects and transmits what arrives, and no more: all of it from inside, where total
// reflection must not add to the base, and from outside without a coat.
TEST( test_mixed_glass_gains_no_energy )
{
    static const float alphas[] = { 0.0f, 0.2f }, iors[] = { 1.5f, 1.0f / 1.5f, -1.5f };
    for ( int k = 0; k < 2 * 3 * 2 * 8; ++k )
    {
        Glass g = { .base = { 0.3f, 0.3f, 0.3f }, .tint = { 0.7f, 0.7f, 0.7f }, .base_share = 0.3f };
        g.alpha = alphas[k % 2];
        g.ior = iors[k / 2 % 3];
        g.bare = (float)( k / 6 % 2 );
        RfVec3 wo = tilted( 5.0f + 11.0f * (float)( k / 12 ) );
        double sum = 0.0;
        for ( int i = 0; i < 4000; ++i )
        {
            float u[3] = { uniform( i, 3 * k ), uniform( i, 3 * k + 1 ), uniform( i, 3 * k + 2 ) };
            Drawn d = draw( &g, wo, u );
            double radiance_scale = d.wi.z < 0.0f && g.ior > 0.0f ? (double)( g.ior * g.ior ) : 1.0;
            sum += (double)d.weight.x * radiance_scale / 4000.0;
        }
        bool whole = g.alpha == 0.0f && ( g.bare == 1.0f || ( g.ior > 0.0f && g.ior < 1.0f ) );
        assert_true( sum <= 1.02 && sum > ( whole ? 0.98 : 0.7 ) );
    }
}

static double fresnel_of( double sine, double n )
{
    double s = sine / n, co = sqrt( 1.0 - sine * sine ), ct = sqrt( fmax( 1.0 - s * s, 0.0 ) );
    if ( s >= 1.0 )
        return 1.0;
    double across = ( co - n * ct ) / ( co + n * ct ), along = ( n * co - ct ) / ( n * co + ct );
    return 0.5 * ( across * across + along * along );
}

static float channel_of( RfVec3 v, int c ) { return c == 0 ? v.x : c == 1 ? v.y : v.z; }

// Each channel is refracted by its own index, alone; all of them are reflected alike; what they carry in the mean is what Fresnel
// reflects and lets through, also between the critical angles of red and blue.
TEST( test_channels_refract_on_their_own )
{
    static const float iors[] = { 1.5f, 1.0f / 1.5f, 2.4f, 1.0f / 2.4f, 1.0001f, 1.0f }, dispersions[] = { 0.36f, 2.0f, 50.0f };
    enum
    {
        COUNT = 3000
    };
    for ( int k = 0; k < 6 * 3 * 30; ++k )
    {
        Glass g = { .tint = { 1, 1, 1 }, .spectral = true, .ior = iors[k % 6], .dispersion = dispersions[k / 6 % 3] };
        float degrees = 1.5f + 3.0f * (float)( k / 18 );
        RfVec3 wo = tilted( degrees );
        double reflected[3] = { 0 }, passed[3] = { 0 };
        for ( int i = 0; i < COUNT; ++i )
        {
            float u[3] = { 0.3f, 0.6f, ( (float)i + 0.5f ) / COUNT };
            Drawn d = draw( &g, wo, u );
            assert_true( d.pdf == RF_DELTA_PDF );
            int carried = 0;
            for ( int c = 0; c < 3; ++c )
            {
                double weight = (double)channel_of( d.weight, c ), n = index_of( &g, c );
                if ( weight > 0.0 && d.wi.z < 0.0f )
                    assert_true( near( d.wi.x, -(double)wo.x / n, 4e-6 ) );
                if ( d.wi.z > 0.0f )
                    assert_true( near( d.wi.x, -(double)wo.x, 1e-6 ) );
                ( d.wi.z > 0.0f ? reflected : passed )[c] += weight * ( d.wi.z > 0.0f ? 1.0 : n * n ) / COUNT;
                carried += weight > 0.0;
            }
            assert_true( d.wi.z > 0.0f || carried == 1 );
        }
        for ( int c = 0; c < 3; ++c )
        {
            double f = fresnel_of( sin( (double)degrees * 3.14159265358979 / 180.0 ), index_of( &g, c ) );
            assert_true( fabs( reflected[c] - f ) < 2e-3 && fabs( passed[c] - ( 1.0 - f ) ) < 4e-3 );
        }
    }
}

// A path that carries one channel goes on as in glass of that channel's index, with the same random numbers: nothing is drawn.
TEST( test_a_path_keeps_its_channel )
{
    for ( int k = 0; k < 20000; ++k )
    {
        int c = k % 3;
        RfVec3 carried = rf_vec3( c == 0 ? 1e-20f : 0.0f, c == 1 ? 7.0f : 0.0f, c == 2 ? 0.1f : 0.0f );
        float outside = 1.0f + 1.5f * uniform( k, 20 );
        Glass g = { .tint = { 0.8f, 0.8f, 0.8f }, .spectral = true };
        g.ior = k % 2 == 0 ? outside : 1.0f / outside;
        g.alpha = k / 2 % 2 == 0 ? 0.0f : 0.4f * uniform( k, 21 ) + RF_MIN_ALPHA;
        g.dispersion = 3.0f * uniform( k, 22 );
        g.choice = rf_pack_channels( carried );
        Glass plain = g;
        plain.spectral = false;
        plain.ior = (float)index_of( &g, c );
        RfVec3 wo = tilted( 89.0f * uniform( k, 23 ) );
        float u[3] = { uniform( k, 24 ), uniform( k, 25 ), uniform( k, 26 ) };
        Drawn a = draw( &g, wo, u ), b = draw( &plain, wo, u );
        RfVec3 apart = rf_sub( a.wi, b.wi );
        if ( rf_length( apart ) > 1e-3f ) // at the edge between two events, or that of total reflection
        {
            u[2] += u[2] < 0.5f ? 1e-3f : -1e-3f;
            a = draw( &g, wo, u );
            b = draw( &plain, wo, u );
            apart = rf_sub( a.wi, b.wi );
        }
        assert_true( rf_length( apart ) < 2e-3f );
        assert_true( fabsf( channel_of( a.weight, c ) - channel_of( b.weight, c ) ) <=
                     2e-3f * channel_of( b.weight, c ) + 1e-6f );
        bool delta = a.pdf == RF_DELTA_PDF;
        assert_true( delta ? b.pdf == RF_DELTA_PDF : fabsf( a.pdf - b.pdf ) <= 3e-3f * b.pdf );
    }
    // what is dark to the last bit is dark, what is not is kept
    float share[3] = { 1.0f, 1e-6f, 0.0f };
    int code = (int)rf_pack_channels( rf_vec3( share[0], share[1], share[2] ) );
    assert_int_equal( code, 255 + 256 );
    assert_int_equal( (int)rf_pack_channels( rf_vec3( 0, 0, 0 ) ), 0 );
    assert_int_equal( (int)rf_pack_channels( rf_vec3( 3, 3, 3 ) ), 255 + 256 * 255 + 65536 * 255 );
}

static Glass filmed( float ior, float alpha, float film )
{
    return ( Glass ){ .tint = { 1, 1, 1 },
                      .ior = ior,
                      .alpha = alpha,
                      .spectral = true,
                      .film = film,
                      .film_ior = 1.33f,
                      .film_thickness = 380.0f };
}

// What a film does not reflect it lets through, in each channel and from both sides alike.
TEST( test_films_reflect_or_transmit )
{
    enum
    {
        COUNT = 2000
    };
    for ( int k = 0; k < 4 * 2 * 17; ++k )
    {
        Glass g = filmed( k % 4 == 0 ? -1.5f : 1.5f, 0.0f, k / 4 % 2 == 0 ? 1.0f : 0.4f );
        g.dispersion = k % 4 == 3 ? 1.0f : 0.0f;
        float sine_outside = sinf( ( 1.0f + 5.2f * (float)( k / 8 ) ) * RF_PI / 180.0f );
        float cosine = sqrtf( 1.0f - sine_outside * sine_outside ), sine = sine_outside;
        double wanted[3];
        for ( int c = 0; c < 3; ++c )
        {
            double n = index_of( &g, c ), bare = fresnel_of( (double)sine_outside, n );
            n = g.ior < 0.0f ? 1.5 : n;
            bare = g.ior < 0.0f ? fresnel_of( (double)sine_outside, n ) : bare;
            float f0 = (float)( ( n - 1 ) / ( n + 1 ) * ( ( n - 1 ) / ( n + 1 ) ) );
            float film = channel_of( rf_film_fresnel( rf_vec3( f0, f0, f0 ), cosine, 1.33f, 380.0f ), c );
            wanted[c] = bare + (double)g.film * ( (double)film - bare );
        }
        if ( k % 4 == 2 ) // the same way from inside
        {
            g.ior = 1.0f / 1.5f;
            sine = sine_outside / 1.5f;
        }
        RfVec3 wo = rf_vec3( sine, 0, sqrtf( 1.0f - sine * sine ) );
        double reflected[3] = { 0 }, passed[3] = { 0 }, scale = g.ior > 0.0f ? (double)( g.ior * g.ior ) : 1.0;
        for ( int i = 0; i < COUNT; ++i )
        {
            float u[3] = { 0.3f, 0.6f, ( (float)i + 0.5f ) / COUNT };
            Drawn d = draw( &g, wo, u );
            for ( int c = 0; c < 3; ++c )
            {
                double n = index_of( &g, c ), squeeze = g.dispersion > 0.0f ? n * n : scale;
                ( d.wi.z > 0.0f ? reflected : passed )[c] +=
                    (double)channel_of( d.weight, c ) * ( d.wi.z > 0.0f ? 1.0 : squeeze ) / COUNT;
            }
        }
        for ( int c = 0; c < 3; ++c )
            assert_true( fabs( reflected[c] - wanted[c] ) < 2e-3 && fabs( passed[c] - ( 1.0 - wanted[c] ) ) < 4e-3 );
        if ( g.ior > 0.0f )
            continue;
        RfMaterial m = { .kind = RF_BSDF_SPECTRAL, .tint = g.tint, .ior = 1.5f, .thin = true, .film = g.film };
        m.film_ior = g.film_ior;
        m.film_thickness = g.film_thickness;
        RfBsdfLanes lanes = lanes_of( &g );
        RfPane a = rf_pane_of_material( &m, wo.z ), b = rf_pane_of_lane( RF_BSDF_SPECTRAL, &lanes, 0, wo );
        assert_true( a.probability == b.probability && a.probability > 0.0f && a.colour.x == b.colour.x );
        for ( int c = 0; c < 3; ++c )
            assert_true( near( channel_of( a.colour, c ), 1.0 - wanted[c], 1e-5 ) );
    }
    // a mirror of metal under a film
    Glass mirror = {
        .specular = { 0.9f, 0.5f, 0.1f }, .spectral = true, .film = 1.0f, .film_ior = 1.5f, .film_thickness = 300.0f
    };
    for ( int k = 0; k < 9; ++k )
    {
        RfVec3 wo = tilted( 10.0f * (float)k ), f = rf_film_fresnel( mirror.specular, wo.z, 1.5f, 300.0f );
        Drawn d = draw( &mirror, wo, s_pass );
        assert_true( d.wi.z > 0.0f && near( d.weight.x, (double)f.x, 1e-5 ) && near( d.weight.z, (double)f.z, 1e-5 ) );
    }
}

TEST( test_rough_spectral_lobes_agree_with_themselves )
{
    static const float degrees[] = { 0.0f, 35.0f, 70.0f };
    for ( int k = 0; k < 3; ++k )
    {
        Glass disperse = { .tint = { 1, 1, 1 }, .alpha = 0.3f, .ior = 1.5f, .spectral = true, .dispersion = 1.0f };
        disperse.choice = rf_pack_channels( rf_vec3( 1.0f, 0.7f, 0.4f ) );
        check_rough( disperse, degrees[k] );
        disperse.ior = 1.0f / 1.5f;
        disperse.base = rf_vec3( 0.3f, 0.3f, 0.3f );
        disperse.tint = rf_vec3( 0.6f, 0.6f, 0.6f );
        disperse.base_share = 0.3f;
        check_rough( disperse, degrees[k] );
        check_rough( filmed( 1.5f, 0.3f, 1.0f ), degrees[k] );
        check_rough( filmed( 1.0f / 1.5f, 0.3f, 0.5f ), degrees[k] );
        check_rough( filmed( -1.5f, 0.3f, 1.0f ), degrees[k] );
    }
}

// The mean of what is drawn, without the scale of radiance, and where it goes.
static void check_smooth( Glass g, float degrees )
{
    enum
    {
        N = 20000
    };
    RfBsdfLanes lanes = lanes_of( &g );
    RfVec3 wo = tilted( degrees );
    RfSmoothLobes lobes = rf_smooth_lobes_of_lane( kind_of( &g ), &lanes, 0, wo );
    double sum[2][3] = { { 0 } }, scale = g.ior > 0.0f ? (double)g.ior * (double)g.ior : 1.0;
    for ( int i = 0; i < N; ++i )
    {
        float u[3] = { 0.3f, 0.6f, ( (float)i + 0.5f ) / N };
        Drawn d = draw( &g, wo, u );
        bool through = d.wi.z < 0.0f;
        if ( d.pdf < RF_DELTA_PDF ) // the base
            continue;
        RfVec3 way = rf_sub( d.wi, through ? lobes.transmitted_wi : lobes.reflected_wi );
        assert_true( rf_length( way ) < 1e-5f );
        for ( int c = 0; c < 3; ++c )
            sum[through][c] += (double)( &d.weight.x )[c] * ( through ? scale : 1.0 ) / N;
    }
    const float *reflected = &lobes.reflected.x, *transmitted = &lobes.transmitted.x, *base = &lobes.base.x;
    for ( int c = 0; c < 3; ++c )
    {
        assert_true( near( reflected[c], sum[0][c], 1e-3 ) && near( transmitted[c], sum[1][c], 1e-3 ) );
        assert_true( base[c] >= 0.0f && base[c] + reflected[c] + transmitted[c] < 1.0f + 1e-5f );
    }
}

TEST( test_smooth_lobes_are_those_that_are_drawn )
{
    static const float degrees[] = { 0.0f, 50.0f, 80.0f };
    for ( int k = 0; k < 3; ++k )
    {
        Glass glass = { .tint = { 0.5f, 0.6f, 0.4f }, .base = { 0.4f, 0.3f, 0.2f }, .ior = 1.5f, .base_share = 0.5f };
        check_smooth( glass, degrees[k] );
        glass.ior = -1.5f;
        check_smooth( glass, degrees[k] );
        glass.ior = 1.0f / 1.5f; // and total reflection
        check_smooth( glass, degrees[k] );
        check_smooth( ( Glass ){ .specular = { 0.9f, 0.5f, 0.1f } }, degrees[k] );
        check_smooth( filmed( -1.5f, 0.0f, 1.0f ), degrees[k] );
    }
}
