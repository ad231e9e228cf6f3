// Evaluates metallic-roughness materials at a point: factors, textures and vertex colours, as BSDF parameters.
#include "scene/textured.h"

#include "base/built_in.h"
#include "base/fault.h"
#include "scene/moments.h"

#include <math.h>
#include <string.h>

// The mean over a triangle is sampled at the centres of GRID² sub-triangles.
#define GRID 8

// Lower bound on the mean emission of a light, as a fraction of its brightest texel: all
// sample points may be black while the light is not.
#define MIN_MEAN 0.02f

// Interpolates a vertex attribute of `components` numbers.
static void interpolate_corners( const float* values, int components, const uint32_t* corners, float u, float v, float* out )
{
    float w = 1.0f - u - v;
    for ( int i = 0; i < components; ++i )
    {
        size_t k = (size_t)i, n = (size_t)components;
        out[i] = w * values[n * corners[0] + k] + u * values[n * corners[1] + k] + v * values[n * corners[2] + k];
    }
}

static const float* uv_array( const RfTriangles* t, int set ) { return set == 0 ? t->uvs : t->uvs1; }

static const uint32_t* corners_of( const RfTriangles* t, uint32_t index ) { return t->indices + 3 * (size_t)index; }

// The texture coordinates u', v' of the point.
static void texture_coordinates( const RfTextureRef* ref, const RfTriangles* t, uint32_t index, float u, float v, float at[2] )
{
    float uv[2] = { 0.0f, 0.0f };
    const float* values = uv_array( t, ref->uv_set );
    if ( values != NULL )
        interpolate_corners( values, 2, corners_of( t, index ), u, v, uv );
    rf_transform_uv( ref, uv, at );
}

// A point of a triangle with a material that has `textured`.
typedef struct Point
{
    const RfScene* scene;
    const RfMaterial* m;
    const RfTriangles* t;
    uint32_t index;
    float u, v;
    float share; // of the triangle that colours are means over
} Point;

static inline Point locate_point( const RfScene* scene, const RfMaterial* m, uint32_t triangle, float u, float v, float share )
{
    RfTriangleAt on = rf_locate_triangle( scene, triangle );
    return ( Point ){ scene, m, on.triangles, on.index, u, v, share };
}

// Slots of colours, in which what a surface sends on is linear or nearly so: means of them are those of the light. Means of
// directions and of roughnesses are not.
#define COLOURS                                                                                                                  \
    ( 1u << RF_TEXTURE_BASE | 1u << RF_TEXTURE_EMISSIVE | 1u << RF_TEXTURE_SPECULAR_COLOR | 1u << RF_TEXTURE_SHEEN_COLOR |       \
      1u << RF_TEXTURE_THROUGH_COLOR )

bool rf_has_colour_texture( const RfMaterial* m )
{
    bool any = false;
    for ( int i = 0; m->textured != NULL && i < RF_TEXTURE_SLOT_COUNT; ++i )
        any = any || ( ( COLOURS >> i & 1 ) && m->textured->refs[i].texture >= 0 );
    return any;
}

// The area of a triangle in square units of u', v'. Coordinates may be so large that floats have no squares of them.
static double area_on_texture( const RfTextureRef* ref, const RfTriangles* t, uint32_t index )
{
    const float *values = uv_array( t, ref->uv_set ), *m = ref->transform;
    if ( values == NULL )
        return 0.0;
    const uint32_t* corners = corners_of( t, index );
    double at[3][2];
    for ( int i = 0; i < 6; ++i )
        at[i / 2][i % 2] = (double)values[2 * (size_t)corners[i / 2] + (size_t)( i % 2 )];
    double det = ( at[1][0] - at[0][0] ) * ( at[2][1] - at[0][1] ) - ( at[1][1] - at[0][1] ) * ( at[2][0] - at[0][0] );
    return 0.5 * fabs( det * ( (double)m[0] * (double)m[4] - (double)m[1] * (double)m[3] ) );
}

// The mip level of a lookup; 0 where it is no mean: alpha may make a roughness, and what is cut out may have any colour.
static float level_of( const Point* p, RfTextureSlot slot )
{
    const RfTextured* m = p->m->textured;
    const RfTexture* texture = p->scene->textures + m->refs[slot].texture;
    bool colour = ( COLOURS >> slot & 1 ) && !( slot == RF_TEXTURE_SPECULAR_COLOR && m->glossy );
    if ( !( p->share > 0.0f ) || texture->levels == NULL || !colour || m->masked || m->blended )
        return 0.0f;
    return rf_mip_level( texture, (double)p->share * area_on_texture( m->refs + slot, p->t, p->index ) );
}

// Looks up a texture slot; false if it has no texture.
static bool look_up_slot( const Point* p, RfTextureSlot slot, float rgba[4] )
{
    const RfTextureRef* ref = p->m->textured->refs + slot;
    if ( ref->texture < 0 )
        return false;
    float at[2];
    texture_coordinates( ref, p->t, p->index, p->u, p->v, at );
    rf_look_up( p->scene->textures + ref->texture, ref, at, level_of( p, slot ), rgba );
    return true;
}

// fmin and fmax are calls, for the sake of NaN.
static inline double lesser( double a, double b ) { return a < b ? a : b; }

static inline double greater( double a, double b ) { return a > b ? a : b; }

static double unit( double x ) { return x > 0.0 ? ( x < 1.0 ? x : 1.0 ) : 0.0; }

// A factor times a channel of the texture in its slot, if there is one.
static double factor_at( const Point* p, RfTextureSlot slot, int channel, double factor )
{
    float rgba[4];
    return look_up_slot( p, slot, rgba ) ? unit( factor * (double)rgba[channel] ) : factor;
}

// What a GGX lobe of white facets reflects of uniform light, the rest being lost among them: a fit, 0.005 off at most.
static double white_albedo( double alpha ) { return 1.0 / ( 1.0 + alpha * ( 0.156 + alpha * ( 1.536 - 0.262 * alpha ) ) ); }

// The least share of its reflectance that a coat must take from the base, both ways, so that the two do not reflect more on
// average than arrives: ρ (1 − k F)² + E F = 1. F is the cosine-weighted mean of Schlick's Fresnel, E the lobe's own albedo.
static double covered_share( const double base[3], double f0, double f90, double alpha )
{
    double mean = f0 + ( f90 - f0 ) / 21.0, brightest = greater( base[0], greater( base[1], base[2] ) );
    double coat = mean * white_albedo( alpha );
    if ( brightest + coat <= 1.0 )
        return 0.0;
    return lesser( ( 1.0 - sqrt( ( 1.0 - coat ) / brightest ) ) / mean, 1.0 );
}

static inline __attribute__( ( always_inline ) ) void derive_lobes( const RfFactors* in, bool translucent, RfMaterial* out )
{
    double m = in->metallic;
    double root = ( in->ior - 1.0 ) / ( in->ior + 1.0 );
    double here[3], diffuse[3], f0[3], coat = 0.0;
    for ( int i = 0; i < 3; ++i )
    {
        // the Fresnel reflectance of the dielectric reduces the diffuse base
        double dielectric = lesser( root * root * in->specular_color[i], 1.0 ) * in->specular;
        coat = greater( coat, dielectric );
        here[i] = translucent ? ( 1.0 - in->through ) * in->base[i] : in->base[i];
        diffuse[i] = ( 1.0 - m ) * here[i];
        f0[i] = ( 1.0 - m ) * dielectric + m * in->base[i];
    }
    out->diffuse = rf_vec3_of( diffuse, 1.0 );
    out->specular = rf_vec3_of( f0, 1.0 );
    out->f90 = (float)( ( 1.0 - m ) * in->specular + m );
    if ( translucent )
    {
        out->through = rf_vec3_of( in->through_color, in->through * ( 1.0 - m ) );
        for ( int i = 0; i < 3; ++i )
            here[i] += in->through * in->through_color[i];
    }
    double covered = in->coat_is_added ? covered_share( here, coat, in->specular, in->roughness * in->roughness ) : 1.0;
    out->coat_f0 = (float)( covered * coat );
    out->coat_f90 = (float)( covered * in->specular );
    out->alpha = rf_maxf( (float)( in->roughness * in->roughness ), RF_FAULT( least_alpha ) ? 0.0f : RF_MIN_ALPHA );
}

void rf_derive_lobes( const RfFactors* in, RfMaterial* out )
{
    if ( in->through > 0.0 || out->kind == RF_BSDF_TRANSLUCENT )
        derive_lobes( in, true, out );
    else
        derive_lobes( in, false, out );
}

static void base_at( const Point* p, double base[4] )
{
    const RfTextured* textured = p->m->textured;
    float rgba[4];
    for ( int i = 0; i < 4; ++i )
        base[i] = textured->factors.base[i];
    if ( look_up_slot( p, RF_TEXTURE_BASE, rgba ) )
    {
        for ( int i = 0; i < 4; ++i )
            base[i] *= (double)rgba[i];
    }
    if ( rf_calls_for( textured->vertex_colors, RF_EFFECT_VERTEX_COLORS ) && p->t->colors != NULL )
    {
        interpolate_corners( p->t->colors, 4, corners_of( p->t, p->index ), p->u, p->v, rgba );
        for ( int i = 0; i < 4; ++i )
            base[i] *= (double)rgba[i];
    }
    for ( int i = 0; i < 4; ++i )
        base[i] = unit( base[i] );
}

static void through_at( const Point* p, RfFactors* f )
{
    float rgba[4];
    if ( look_up_slot( p, RF_TEXTURE_THROUGH, rgba ) )
        f->through *= unit( (double)rgba[3] );
    if ( look_up_slot( p, RF_TEXTURE_THROUGH_COLOR, rgba ) )
    {
        for ( int i = 0; i < 3; ++i )
            f->through_color[i] *= unit( (double)rgba[i] );
    }
}

// What rf_derive_lobes and rf_derive_glass read.
static inline RfFactors factors_at( const Point* p )
{
    RfFactors f;
    memcpy( &f, &p->m->textured->factors, offsetof( RfFactors, sheen_color ) );
    float rgba[4];
    base_at( p, f.base );
    if ( look_up_slot( p, RF_TEXTURE_METALLIC_ROUGHNESS, rgba ) )
    {
        f.roughness = unit( f.roughness * (double)rgba[1] );
        f.metallic = unit( f.metallic * (double)rgba[2] );
    }
    f.specular = factor_at( p, RF_TEXTURE_SPECULAR, 3, f.specular );
    if ( look_up_slot( p, RF_TEXTURE_SPECULAR_COLOR, rgba ) )
    {
        for ( int i = 0; i < 3; ++i )
            f.specular_color[i] *= (double)rgba[i];
        if ( p->m->textured->glossy )
            f.roughness = unit( 1.0 - ( 1.0 - f.roughness ) * (double)rgba[3] );
    }
    if ( f.through > 0.0 )
        through_at( p, &f );
    return f;
}

void rf_derive_glass( const RfFactors* f, double transmission, RfMaterial* out )
{
    double dielectric = 1.0 - f->metallic;
    out->alpha = f->roughness < RF_SMOOTH_ROUGHNESS ? 0.0f : (float)( f->roughness * f->roughness );
    out->tint = rf_vec3_of( f->base, transmission * dielectric );
    out->diffuse = rf_vec3_of( f->base, ( 1.0 - transmission ) * dielectric );
    out->specular = rf_vec3_of( f->base, f->metallic );
    out->f90 = (float)f->metallic;
    out->coat_f0 = (float)( 1.0 - transmission );
    out->coat_f90 = (float)( 1.0 - lesser( f->specular, 1.0 ) );
}

void rf_derive_clearcoat( double clearcoat, double roughness, RfMaterial* out )
{
    out->clearcoat = (float)clearcoat;
    out->clearcoat_alpha = rf_maxf( (float)( roughness * roughness ), RF_MIN_ALPHA );
}

static void glass_at( const Point* p, const RfFactors* f, RfMaterial* out )
{
    if ( out->ior == 0.0f ) // a mirror: textures do not affect its roughness
    {
        out->specular = rf_vec3_of( f->base, 1.0 );
        return;
    }
    rf_derive_glass( f, factor_at( p, RF_TEXTURE_TRANSMISSION, 0, p->m->textured->transmission ), out );
}

static float sheen_alpha( double roughness )
{
    return rf_maxf( (float)( roughness * roughness ), RF_FAULT( least_sheen ) ? 0.0f : RF_MIN_SHEEN_ALPHA );
}

static void derive_sheen( const RfFactors* f, RfMaterial* out )
{
    out->sheen = rf_vec3_of( f->sheen_color, 1.0 );
    out->sheen_alpha = sheen_alpha( f->sheen_roughness );
}

static void derive_stretch( const RfFactors* f, RfMaterial* out )
{
    out->anisotropy = (float)f->anisotropy;
    out->stretch_x = (float)cos( f->anisotropy_rotation );
    out->stretch_y = (float)sin( f->anisotropy_rotation );
}

static void derive_film( const RfFactors* f, double thickness, RfMaterial* out )
{
    out->film = (float)f->film;
    out->film_ior = (float)f->film_ior;
    out->film_thickness = (float)thickness;
}

void rf_derive_layers( const RfFactors* f, RfMaterial* out )
{
    derive_sheen( f, out );
    derive_stretch( f, out );
    derive_film( f, f->film_most, out );
}

static void clearcoat_at( const Point* p, RfMaterial* out )
{
    const RfTextured* t = p->m->textured;
    rf_derive_clearcoat( factor_at( p, RF_TEXTURE_CLEARCOAT, 0, t->clearcoat ),
                         factor_at( p, RF_TEXTURE_CLEARCOAT_ROUGHNESS, 1, t->clearcoat_roughness ), out );
}

static void sheen_at( const Point* p, RfMaterial* out )
{
    float rgba[4];
    if ( look_up_slot( p, RF_TEXTURE_SHEEN_COLOR, rgba ) )
        out->sheen = rf_mul( p->m->sheen, rf_vec3( (float)unit( (double)rgba[0] ), (float)unit( (double)rgba[1] ),
                                                   (float)unit( (double)rgba[2] ) ) );
    if ( look_up_slot( p, RF_TEXTURE_SHEEN_ROUGHNESS, rgba ) )
        out->sheen_alpha = sheen_alpha( unit( p->m->textured->factors.sheen_roughness * (double)rgba[3] ) );
}

// The texture has the direction, which the factor turns further, and a share of the strength.
static void stretch_at( const Point* p, RfMaterial* out )
{
    float rgba[4];
    if ( !look_up_slot( p, RF_TEXTURE_ANISOTROPY, rgba ) )
        return;
    out->anisotropy = p->m->anisotropy * (float)unit( (double)rgba[2] );
    float x = 2.0f * (float)unit( (double)rgba[0] ) - 1.0f, y = 2.0f * (float)unit( (double)rgba[1] ) - 1.0f;
    float length2 = x * x + y * y;
    if ( !( length2 > 1e-4f ) ) // between texels of opposite directions: none
        return;
    float scale = 1.0f / sqrtf( length2 );
    out->stretch_x = scale * ( p->m->stretch_x * x - p->m->stretch_y * y );
    out->stretch_y = scale * ( p->m->stretch_y * x + p->m->stretch_x * y );
}

static void film_at( const Point* p, RfMaterial* out )
{
    const RfFactors* f = &p->m->textured->factors;
    float rgba[4];
    if ( look_up_slot( p, RF_TEXTURE_FILM, rgba ) )
        out->film = p->m->film * (float)unit( (double)rgba[0] );
    if ( look_up_slot( p, RF_TEXTURE_FILM_THICKNESS, rgba ) )
        out->film_thickness = (float)( f->film_least + ( f->film_most - f->film_least ) * unit( (double)rgba[1] ) );
}

// What lies over GGX or changes its lobe.
static void layers_at( const Point* p, RfMaterial* out )
{
    RfBsdfParams params = rf_bsdf_model( p->m->kind )->params;
    if ( rf_has_param( params, RF_PARAM_CLEARCOAT ) )
        clearcoat_at( p, out );
    if ( rf_has_param( params, RF_PARAM_SHEEN ) )
        sheen_at( p, out );
    if ( rf_has_param( params, RF_PARAM_ANISOTROPY ) )
        stretch_at( p, out );
    if ( rf_has_param( params, RF_PARAM_FILM ) )
        film_at( p, out );
}

void rf_material_within( const RfScene* scene, const RfMaterial* m, uint32_t triangle, float u, float v, float share,
                         RfMaterial* out )
{
    *out = *m;
    if ( m->textured->model == RF_TEXTURED_UNLIT )
        return;
    const Point p = locate_point( scene, m, triangle, u, v, share );
    RfFactors f = factors_at( &p );
    switch ( m->textured->model )
    {
        case RF_TEXTURED_COATED: rf_derive_lobes( &f, out ); break;
        case RF_TEXTURED_GLASS: glass_at( &p, &f, out ); break;
        case RF_TEXTURED_DIFFUSE: out->diffuse = rf_mul( m->diffuse, rf_vec3_of( f.base, 1.0 ) ); break;
        case RF_TEXTURED_UNLIT: break;
    }
    if ( m->kind > RF_BSDF_GGX && m->kind != RF_BSDF_GLASS )
        layers_at( &p, out );
}

void rf_derive_material( RfMaterial* m )
{
    const RfTextured* t = m->textured;
    switch ( t->model )
    {
        case RF_TEXTURED_COATED: rf_derive_lobes( &t->factors, m ); break;
        case RF_TEXTURED_GLASS:
            if ( m->ior == 0.0f )
                m->specular = rf_vec3_of( t->factors.base, 1.0 );
            else
                rf_derive_glass( &t->factors, t->transmission, m );
            break;
        case RF_TEXTURED_UNLIT: m->emission = rf_vec3_of( t->factors.base, 1.0 ); break;
        case RF_TEXTURED_DIFFUSE: break;
    }
}

bool rf_is_clear_somewhere( const RfMaterial* m )
{
    if ( m->ior == 0.0f ) // a mirror
        return false;
    if ( m->textured == NULL )
        return m->alpha == 0.0f && rf_max_component( m->tint ) > 0.0f;
    // textures are factors: they make rough surfaces smooth, but nothing rougher
    bool smooth = m->alpha == 0.0f || rf_roughness_varies( m );
    return smooth && m->textured->transmission > 0.0;
}

static bool is_cut_out( const Point* p )
{
    double base[4];
    base_at( p, base );
    return base[3] < (double)p->m->textured->alpha_cutoff;
}

static float opacity_at( const Point* p )
{
    if ( p->m->textured->masked )
        return is_cut_out( p ) ? 0.0f : 1.0f;
    double base[4];
    base_at( p, base );
    return p->m->textured->blended ? (float)unit( base[3] ) : 1.0f;
}

float rf_opacity_on( const RfScene* scene, const RfMaterial* m, const RfTriangles* t, uint32_t index, float u, float v )
{
    return opacity_at( &( Point ){ scene, m, t, index, u, v, 0.0f } );
}

float rf_opacity_at( const RfScene* scene, const RfMaterial* m, uint32_t triangle, float u, float v )
{
    const Point p = locate_point( scene, m, triangle, u, v, 0.0f );
    return opacity_at( &p );
}

RfVec3 rf_emission_within( const RfScene* scene, const RfMaterial* m, uint32_t triangle, float u, float v, float share )
{
    const Point p = locate_point( scene, m, triangle, u, v, share );
    if ( m->textured->masked && is_cut_out( &p ) )
        return rf_vec3( 0, 0, 0 );
    if ( m->textured->model == RF_TEXTURED_UNLIT )
    {
        double base[4];
        base_at( &p, base );
        return rf_vec3_of( base, 1.0 );
    }
    float rgba[4];
    if ( !look_up_slot( &p, RF_TEXTURE_EMISSIVE, rgba ) )
        return m->emission;
    return rf_mul( m->emission, rf_vec3( rgba[0], rgba[1], rgba[2] ) );
}

// An upper bound of the factor that textures apply to the emission of a triangle.
static float bound_emission( const RfScene* scene, const RfMaterial* m, uint32_t triangle )
{
    RfTextureSlot slot = m->textured->model == RF_TEXTURED_UNLIT ? RF_TEXTURE_BASE : RF_TEXTURE_EMISSIVE;
    const RfTextureRef* ref = m->textured->refs + slot;
    if ( ref->texture < 0 )
        return 1.0f;
    RfTriangleAt on = rf_locate_triangle( scene, triangle );
    float low[2], high[2];
    for ( int corner = 0; corner < 3; ++corner )
    {
        float at[2];
        texture_coordinates( ref, on.triangles, on.index, corner == 1 ? 1.0f : 0.0f, corner == 2 ? 1.0f : 0.0f, at );
        for ( int k = 0; k < 2; ++k )
        {
            low[k] = corner == 0 || at[k] < low[k] ? at[k] : low[k];
            high[k] = corner == 0 || at[k] > high[k] ? at[k] : high[k];
        }
    }
    return rf_texture_bound( scene->textures + ref->texture, ref, low, high );
}

RfVec3 rf_mean_emission( const RfScene* scene, const RfMaterial* m, uint32_t triangle )
{
    float bound = bound_emission( scene, m, triangle );
    RfVec3 sum = rf_vec3( 0, 0, 0 );
    if ( bound == 0.0f )
        return sum;
    for ( int i = 0; i < GRID; ++i )
    {
        for ( int k = 0; k < 2 * i + 1; ++k ) // row i has i + 1 upright and i inverted sub-triangles
        {
            // whole pairs: NOLINTNEXTLINE(bugprone-integer-division)
            float across = ( (float)( k / 2 ) + ( k & 1 ? 2.0f : 1.0f ) / 3.0f ) / (float)GRID;
            float along = ( (float)i + ( k & 1 ? 1.0f : 2.0f ) / 3.0f ) / (float)GRID;
            sum = rf_add( sum, rf_emission_at( scene, m, triangle, along - across, across ) );
        }
    }
    RfVec3 mean = rf_scale( sum, 1.0f / (float)( GRID * GRID ) );
    RfVec3 least = rf_scale( m->emission, MIN_MEAN * bound );
    return rf_luminance( mean ) > rf_luminance( least ) ? mean : least;
}

// Shading normals of surfaces and clear coats from normal textures.

// True if the vertex tangents belong to this use of a texture. They belong to the normal
// texture of the surface or, without one, to that of the coat.
static bool has_vertex_tangents( const RfTriangles* t, const RfTextured* textured, const RfTextureRef* ref )
{
    const RfTextureRef* of = textured->refs + RF_TEXTURE_NORMAL;
    if ( t->tangents == NULL || textured->turns )
        return false;
    // the bits of the same file: NOLINTNEXTLINE(bugprone-suspicious-memory-comparison)
    return of->texture < 0 || ( of->uv_set == ref->uv_set && memcmp( of->transform, ref->transform, sizeof of->transform ) == 0 );
}

static bool is_mirrored( const RfTriangleAt* on )
{
    return on->placement != NULL && rf_mat4_det3( &on->placement->matrix ) < 0.0;
}

// The interpolated vertex tangent in the world, with its sign.
static void vertex_tangent( const RfTriangleAt* on, float u, float v, float out[4] )
{
    const uint32_t* corners = corners_of( on->triangles, on->index );
    const float* tangents = on->triangles->tangents;
    float placed[12];
    static const uint32_t own[3] = { 0, 1, 2 };
    if ( on->placement == NULL )
    {
        interpolate_corners( tangents, 4, corners, u, v, out );
        return;
    }
    float side = is_mirrored( on ) ? -1.0f : 1.0f;
    for ( int k = 0; k < 3; ++k )
    {
        const float* t = tangents + 4 * (size_t)corners[k];
        RfVec3 d = rf_place_direction( &on->placement->matrix, rf_vec3( t[0], t[1], t[2] ) );
        memcpy( placed + 4 * k, &d, 3 * sizeof *placed );
        placed[4 * k + 3] = rf_dot( d, d ) > 0.0f ? t[3] * side : 0.0f;
    }
    interpolate_corners( placed, 4, own, u, v, out );
}

// The direction of u' along a triangle in the world, and the sign of the bitangent. False: its coordinates span no area.
static bool face_tangent( const RfTextureRef* ref, const RfTriangleAt* on, RfVec3* along, float* sign )
{
    const uint32_t* corners = corners_of( on->triangles, on->index );
    float a[2], b[2], c[2], p[3][3];
    texture_coordinates( ref, on->triangles, on->index, 0.0f, 0.0f, a );
    texture_coordinates( ref, on->triangles, on->index, 1.0f, 0.0f, b );
    texture_coordinates( ref, on->triangles, on->index, 0.0f, 1.0f, c );
    for ( int i = 0; i < 3; ++i )
    {
        interpolate_corners( on->triangles->positions, 3, corners, i == 1 ? 1.0f : 0.0f, i == 2 ? 1.0f : 0.0f, p[i] );
        if ( on->placement == NULL )
            continue;
        RfVec3 world = rf_place_point( &on->placement->matrix, rf_vec3( p[i][0], p[i][1], p[i][2] ) );
        memcpy( p[i], &world, sizeof p[i] );
    }
    RfVec3 e1 = rf_vec3( p[1][0] - p[0][0], p[1][1] - p[0][1], p[1][2] - p[0][2] );
    RfVec3 e2 = rf_vec3( p[2][0] - p[0][0], p[2][1] - p[0][1], p[2][2] - p[0][2] );
    float du1 = b[0] - a[0], dv1 = b[1] - a[1], du2 = c[0] - a[0], dv2 = c[1] - a[1];
    float det = du1 * dv2 - du2 * dv1;
    if ( !( fabsf( det ) > 0.0f ) )
        return false;
    // v' points down the image and the bitangent up: for det < 0 it is n × t, unless the corners are seen in reverse order
    *along = rf_scale( rf_sub( rf_scale( e1, dv2 ), rf_scale( e2, dv1 ) ), det < 0.0f ? -1.0f : 1.0f );
    *sign = ( det < 0.0f ) != is_mirrored( on ) ? 1.0f : -1.0f;
    return true;
}

// Tangent and bitangent, from the vertex tangents (`of_vertices`) or else from the texture coordinates.
static bool find_tangents( bool of_vertices, const RfTextureRef* ref, const RfTriangleAt* on, float u, float v, RfVec3 n,
                           RfVec3* tangent, RfVec3* bitangent )
{
    RfVec3 along;
    float sign = 0.0f;
    if ( of_vertices )
    {
        float given[4];
        vertex_tangent( on, u, v, given );
        along = rf_vec3( given[0], given[1], given[2] );
        sign = given[3];
    }
    if ( sign == 0.0f && !face_tangent( ref, on, &along, &sign ) )
        return false;
    along = rf_madd( along, n, -rf_dot( along, n ) );
    float length2 = rf_dot( along, along );
    if ( !( length2 > 0.0f && length2 < INFINITY ) )
        return false;
    *tangent = rf_scale( along, 1.0f / sqrtf( length2 ) );
    *bitangent = rf_scale( rf_cross( n, *tangent ), sign < 0.0f ? -1.0f : 1.0f );
    return true;
}

// Where a triangle is at the moment that the scene is looked at.
static RfTriangleAt locate_now( const RfScene* scene, uint32_t triangle, RfBetween* between )
{
    RfTriangleAt on = rf_locate_triangle( scene, triangle );
    return rf_is_between( scene, on.placement ) ? rf_triangle_between( scene, &on, between ) : on;
}

static RfVec3 mapped_normal( const RfScene* scene, const RfMaterial* m, RfTextureSlot slot, float scale, uint32_t triangle,
                             float u, float v, RfVec3 n, RfVec3 ng )
{
    float rgba[4];
    RfVec3 tangent, bitangent;
    RfBetween between;
    RfTriangleAt on = locate_now( scene, triangle, &between );
    const RfTextureRef* ref = m->textured->refs + slot;
    if ( !look_up_slot( &( Point ){ scene, m, on.triangles, on.index, u, v, 0.0f }, slot, rgba ) ||
         !find_tangents( has_vertex_tangents( on.triangles, m->textured, ref ), ref, &on, u, v, n, &tangent, &bitangent ) )
        return n;
    float x = ( 2.0f * rgba[0] - 1.0f ) * scale, y = ( 2.0f * rgba[1] - 1.0f ) * scale;
    RfVec3 mapped = rf_madd( rf_madd( rf_scale( n, 2.0f * rgba[2] - 1.0f ), tangent, x ), bitangent, y );
    float length2 = rf_dot( mapped, mapped );
    if ( !( length2 > 1e-12f ) )
        return n;
    mapped = rf_scale( mapped, 1.0f / sqrtf( length2 ) );
    // a normal that points below the surface is raised to the horizon
    float above = rf_dot( mapped, ng );
    return above > 1e-3f ? mapped : rf_normalize( rf_madd( mapped, ng, 2e-3f - above ) );
}

RfVec3 rf_normal_at( const RfScene* scene, const RfMaterial* m, uint32_t triangle, float u, float v, RfVec3 n, RfVec3 ng )
{
    return mapped_normal( scene, m, RF_TEXTURE_NORMAL, m->textured->normal_scale, triangle, u, v, n, ng );
}

RfVec3 rf_coat_normal_at( const RfScene* scene, const RfMaterial* m, uint32_t triangle, float u, float v, RfVec3 n, RfVec3 ng )
{
    return mapped_normal( scene, m, RF_TEXTURE_CLEARCOAT_NORMAL, m->textured->clearcoat_normal_scale, triangle, u, v, n, ng );
}

// The texture whose coordinates say where the tangent is if no vertices do.
static const RfTextureRef* find_stretch_texture( const RfTextured* textured )
{
    static const RfTextureRef s_plain = { .texture = -1, .transform = { 1, 0, 0, 0, 1, 0 } };
    if ( textured == NULL )
        return &s_plain;
    const RfTextureRef *own = textured->refs + RF_TEXTURE_ANISOTROPY, *of_normals = textured->refs + RF_TEXTURE_NORMAL;
    return own->texture >= 0 ? own : of_normals->texture >= 0 ? of_normals : &s_plain;
}

RfVec3 rf_stretch_at( const RfScene* scene, const RfMaterial* m, uint32_t triangle, float u, float v, RfVec3 n )
{
    RfVec3 tangent, bitangent;
    RfBetween between;
    RfTriangleAt on = locate_now( scene, triangle, &between );
    const RfTextureRef* ref = find_stretch_texture( m->textured );
    if ( !find_tangents( on.triangles->tangents != NULL, ref, &on, u, v, n, &tangent, &bitangent ) )
        rf_basis( n, &tangent, &bitangent );
    return rf_normalize( rf_madd( rf_scale( tangent, m->stretch_x ), bitangent, m->stretch_y ) );
}

static inline RfTriangleAt locate( const RfScene* scene, uint32_t triangle, bool placed )
{
    return placed ? rf_locate_triangle( scene, triangle ) : ( RfTriangleAt ){ &scene->triangles, triangle, NULL };
}

// The slots of a model's textures are those before this one.
static inline int slots_end( RfBsdfKind kind )
{
    if ( kind <= RF_BSDF_GGX )
        return RF_TEXTURE_TRANSMISSION;
    return kind == RF_BSDF_GLASS ? RF_TEXTURE_CLEARCOAT : kind == RF_BSDF_COATED ? RF_TEXTURE_SHEEN_COLOR : RF_TEXTURE_SLOT_COUNT;
}

// Fetches the corners' indices, which say where their texture coordinates are; then these; then the texels. `placed`: triangles may
// be those of placements.
static inline __attribute__( ( always_inline ) ) void fetch_all( const RfScene* scene, const RfTexturedPoint* points, int count,
                                                                 bool placed )
{
    for ( int i = 0; i < count; ++i )
    {
        RfTriangleAt on = locate( scene, points[i].triangle, placed );
        __builtin_prefetch( corners_of( on.triangles, on.index ) );
    }
    for ( int i = 0; i < count; ++i )
    {
        RfTriangleAt on = locate( scene, points[i].triangle, placed );
        const uint32_t* corners = corners_of( on.triangles, on.index );
        for ( int k = 0; k < 3 && on.triangles->uvs != NULL; ++k )
            __builtin_prefetch( on.triangles->uvs + 2 * (size_t)corners[k] );
    }
    for ( int i = 0; i < count; ++i )
    {
        const RfTextureRef* refs = points[i].material->textured->refs;
        RfTriangleAt on = locate( scene, points[i].triangle, placed );
        int end = slots_end( points[i].material->kind );
        for ( int slot = 0; slot < end; ++slot )
        {
            if ( refs[slot].texture < 0 )
                continue;
            float at[2];
            texture_coordinates( refs + slot, on.triangles, on.index, points[i].u, points[i].v, at );
            rf_prefetch_texels( scene->textures + refs[slot].texture, refs + slot, at );
        }
    }
}

void rf_prefetch_textures( const RfScene* scene, const RfTexturedPoint* points, int count )
{
    if ( scene->placement_count > 0 )
        fetch_all( scene, points, count, true );
    else
        fetch_all( scene, points, count, false );
}
