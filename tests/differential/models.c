#include "differential/models.h"

static float unit( uint32_t stream, long i, uint32_t dimension )
{
    return (float)random_between( 0.0, 1.0, stream, i, dimension );
}

static float random_ior( uint32_t stream, long i )
{
    static const float s_ior[] = { 0.0f,        1.0f, 1.0001f, 1.5f,     10.0f, 1.0f / 1.0001f,
                                   1.0f / 1.5f, 0.1f, -1.0f,   -1.0001f, -1.5f, -10.0f };
    int k = (int)( 16.0 * random_number( stream, i, 30 ) );
    if ( k < 12 )
        return s_ior[k];
    float ior = (float)random_wide( 0.1, 10.0, stream, i, 31 );
    return k == 15 ? -( ior < 1.0f ? 1.0f / ior : ior ) : ior;
}

static void make_glass_of( Surface* s, uint32_t stream, long i )
{
    float metal = random_number( stream, i, 32 ) < 0.5 ? 0.0f : unit( stream, i, 33 );
    s->ior = random_ior( stream, i );
    s->f90 = metal;
    s->coat_f0 = s->coat_f90 = 0.0f; // whose shares of the surface test_glass checks
    s->shape = random_number( stream, i, 34 ) < 0.3 ? 0.0f : (float)random_wide( (double)RF_MIN_ALPHA, 1.0, stream, i, 22 );
    if ( s->ior == 0.0f )
    {
        s->tint = 0.0f;
        return;
    }
    s->diffuse *= 1.0f - metal;
    s->specular *= metal;
    s->tint = unit( stream, i, 35 ) * ( 1.0f - metal );
}

Surface random_surface( RfBsdfKind kind, uint32_t stream, long i )
{
    Surface s = { .n = random_direction( stream, i, 1 ) };
    s.wo = random_around( s.n, stream, i, 4 );
    s.diffuse = unit( stream, i, 20 );
    s.specular = unit( stream, i, 21 );
    s.shape = (float)random_wide( (double)RF_MIN_ALPHA, 1.0, stream, i, 22 );
    if ( kind == RF_BSDF_PHONG )
        s.shape = random_number( stream, i, 23 ) < 0.05 ? 0.0f : (float)random_wide( 1e-3, 1e7, stream, i, 22 );
    s.f90 = unit( stream, i, 24 );
    s.coat_f0 = unit( stream, i, 25 );
    s.coat_f90 = unit( stream, i, 26 );
    s.clearcoat = unit( stream, i, 27 );
    s.clearcoat_alpha = (float)random_wide( (double)RF_MIN_ALPHA, 1.0, stream, i, 28 );
    s.coat_n = s.n;
    if ( random_number( stream, i, 29 ) < 0.5 ) // bumps below the coat, up to some 45°
    {
        RfVec3 lean = random_direction( stream, i, 40 );
        s.coat_n = rf_normalize( rf_madd( s.n, lean, (float)random_wide( 1e-6, 0.7, stream, i, 42 ) ) );
    }
    if ( kind == RF_BSDF_GLASS )
        make_glass_of( &s, stream, i );
    return s;
}

void add_surface( Inputs* in, RfBsdfKind kind, const Surface* s, RfVec3 wi )
{
    *in = ( Inputs ){ 0 };
    add_direction( in, s->n );
    add_direction( in, s->wo );
    add_direction( in, wi );
    add_number( in, (double)s->diffuse );
    if ( kind == RF_BSDF_LAMBERT )
        return;
    add_number( in, (double)s->specular );
    add_number( in, (double)s->shape );
    if ( kind == RF_BSDF_PHONG )
    {
        add_rounding( in );
        return;
    }
    add_number( in, (double)s->f90 );
    if ( kind == RF_BSDF_GLASS )
    {
        add_number( in, (double)s->tint );
        add_number( in, (double)s->ior );
        add_rounding( in );
        return;
    }
    add_number( in, (double)s->coat_f0 );
    add_number( in, (double)s->coat_f90 );
    add_rounding( in );
    if ( kind != RF_BSDF_COATED )
        return;
    add_number( in, (double)s->clearcoat );
    add_number( in, (double)s->clearcoat_alpha );
    add_direction( in, s->coat_n );
}
