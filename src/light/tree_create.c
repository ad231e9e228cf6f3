#include "light/tree_create.h"

#include <math.h>
#include <stdlib.h>

// Distance of directional lights, in radii of the scene. Their direction is off by
// at most its inverse, which the slack of rf_light_importance covers.
#define DISTANT 1e4

static void set_axis( RfTreeLight* out, RfVec3 v )
{
    double x = (double)v.x, y = (double)v.y, z = (double)v.z, length = sqrt( x * x + y * y + z * z );
    out->axis[0] = x / length;
    out->axis[1] = y / length;
    out->axis[2] = z / length;
}

static void extend_box( RfTreeLight* out, const RfLights* lights, RfVec3 p )
{
    double p_ball[3] = { (double)p.x - (double)lights->center.x, (double)p.y - (double)lights->center.y,
                         (double)p.z - (double)lights->center.z };
    for ( int i = 0; i < 3; ++i )
    {
        p_ball[i] *= (double)lights->inverse_radius;
        out->low[i] = fmin( out->low[i], p_ball[i] );
        out->high[i] = fmax( out->high[i], p_ball[i] );
    }
}

static RfTreeLight empty( uint32_t number )
{
    return ( RfTreeLight ){ .low = { INFINITY, INFINITY, INFINITY },
                            .high = { -INFINITY, -INFINITY, -INFINITY },
                            .axis = { 0, 0, 1 },
                            .cos_spread = -1.0,
                            .light = number };
}

// Scales intensities: the tree measures distances in radii of the scene.
static double per_ball( const RfLights* lights ) { return (double)lights->inverse_radius * (double)lights->inverse_radius; }

static RfTreeLight from_triangle( const RfLights* lights, uint32_t number )
{
    const RfLight* light = lights->light + number;
    RfTreeLight out = empty( number );
    extend_box( &out, lights, light->p0 );
    extend_box( &out, lights, rf_add( light->p0, light->e1 ) );
    extend_box( &out, lights, rf_add( light->p0, light->e2 ) );
    set_axis( &out, light->normal );
    out.cos_spread = 1.0;
    out.two_sided = light->two_sided;
    out.intensity = (double)rf_luminance( light->radiance ) * (double)light->area * per_ball( lights );
    return out;
}

static RfTreeLight from_punctual( const RfLights* lights, uint32_t number )
{
    const RfPunctual* p = lights->punctual + ( number - lights->triangle_count );
    RfTreeLight out = empty( number );
    out.intensity = (double)rf_luminance( p->intensity ) * per_ball( lights );
    if ( p->kind == RF_PUNCTUAL_DIRECTIONAL )
    {
        set_axis( &out, p->direction );
        for ( int i = 0; i < 3; ++i )
            out.low[i] = out.high[i] = -DISTANT * out.axis[i];
        out.intensity = (double)rf_luminance( p->intensity ) * DISTANT * DISTANT;
        return out;
    }
    extend_box( &out, lights, p->position );
    if ( p->kind == RF_PUNCTUAL_SPOT )
    {
        set_axis( &out, p->direction );
        out.cos_spread = (double)p->cos_inner;
        out.cos_emission = cos( acos( (double)p->cos_outer ) - acos( (double)p->cos_inner ) );
    }
    return out;
}

RfResult rf_create_light_tree( RfLights* lights, RfError* error )
{
    uint32_t count = lights->count - rf_has_sky( lights );
    RfTreeLight* leaves = malloc( (size_t)( count + 1 ) * sizeof *leaves );
    if ( leaves == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "no memory for a tree of %u lights", count );
    double sky = rf_has_sky( lights ) ? 3.14159265358979324 * (double)lights->sky.mean_luminance : 0.0, sum = sky;
    for ( uint32_t i = 0; i < count; ++i )
    {
        leaves[i] = i < lights->triangle_count ? from_triangle( lights, i ) : from_punctual( lights, i );
        sum += leaves[i].intensity;
    }
    for ( uint32_t i = 0; i < count; ++i )
        leaves[i].intensity /= sum;
    lights->sky_scale = rf_has_sky( lights ) ? (float)( 1.0 / sum ) : 0.0f;
    RfResult result = rf_build_light_tree( leaves, count, lights->count, &lights->tree, error );
    free( leaves );
    return result;
}
