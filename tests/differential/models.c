#include "differential/models.h"

#include "bsdf/sheen.h"

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

static void make_layers_of( Surface* s, uint32_t stream, long i )
{
    RfVec3 t, b;
    float turn = 6.2831853f * unit( stream, i, 46 );
    rf_basis( s->n, &t, &b );
    s->tangent = rf_madd( rf_scale( t, cosf( turn ) ), b, sinf( turn ) );
    s->anisotropy = unit( stream, i, 47 );
    s->film = unit( stream, i, 48 );
    s->film_ior = (float)random_wide( 1.0, 100.0, stream, i, 49 );
    s->film_thickness = random_number( stream, i, 70 ) < 0.1 ? 0.0f : (float)random_wide( 0.1, 1e5, stream, i, 71 );
}

// The normal is on the side that light was drawn to arrive on.
static void make_sheet_of( Surface* s, uint32_t stream, long i )
{
    s->through = unit( stream, i, 72 );
    s->side = random_number( stream, i, 73 ) < 0.5 ? -1.0f : 1.0f;
    if ( s->side < 0.0f )
        s->wo = random_around( rf_scale( s->n, -1.0f ), stream, i, 4 );
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
    s.sheen = unit( stream, i, 43 );
    s.sheen_alpha = (float)random_wide( (double)RF_MIN_SHEEN_ALPHA, 1.0, stream, i, 44 );
    make_layers_of( &s, stream, i );
    if ( kind == RF_BSDF_GLASS )
        make_glass_of( &s, stream, i );
    if ( kind == RF_BSDF_TRANSLUCENT )
        make_sheet_of( &s, stream, i );
    return s;
}

static void add_layers( Inputs* in, const Surface* s, RfVec3 wi )
{
    float missing = RF_MIN_COS - rf_dot( s->n, s->wo );
    RfVec3 eye = missing > 0.0f ? rf_normalize( rf_madd( s->wo, s->n, missing ) ) : s->wo;
    add_number( in, (double)s->clearcoat );
    add_number( in, (double)s->clearcoat_alpha );
    add_direction( in, s->coat_n );
    add_number( in, (double)s->sheen );
    add_number( in, (double)s->sheen_alpha );
    add_number( in, (double)rf_sheen_albedo( rf_dot( s->n, eye ), s->sheen_alpha ) );
    add_number( in, (double)rf_sheen_albedo( rf_dot( s->n, wi ), s->sheen_alpha ) );
    in->step[in->count - 2] = in->step[in->count - 1] = 16.0 * UNIT_ROUNDOFF; // those of its polynomial
    add_number( in, (double)s->anisotropy );
    add_direction( in, s->tangent );
    add_number( in, (double)s->film );
    add_number( in, (double)s->film_ior );
    add_number( in, (double)s->film_thickness );
    add_rounding( in );
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
    if ( kind == RF_BSDF_TRANSLUCENT )
    {
        add_number( in, (double)s->through );
        in->x[in->count++] = (double)s->side;
    }
    else if ( kind != RF_BSDF_GGX )
        add_layers( in, s, wi );
}
