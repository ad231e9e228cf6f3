#include "light/light.h"

// Where the tree has x: in units of the ball around the scene.
static RfVec3 in_ball( const RfLights* lights, RfVec3 x )
{
    return rf_scale( rf_sub( x, lights->center ), lights->inverse_radius );
}

static float weigh_sky( const RfLights* lights, RfVec3 n )
{
    return rf_has_sky( lights ) ? rf_sky_irradiance_estimate( &lights->sky, n ) * lights->sky_scale : 0.0f;
}

static double sum_of( const float weight[RF_LIGHT_CHILDREN] )
{
    double sum = 0.0;
    for ( int k = 0; k < RF_LIGHT_CHILDREN; ++k )
        sum += (double)weight[k];
    return sum;
}

// The child in which `u` in [0, 1) of the whole lies; u becomes the place
// within that. The sum is above 0.
static int pick_child( const float weight[RF_LIGHT_CHILDREN], double sum, double* u )
{
    double rest = *u * sum;
    int last = 0;
    for ( int k = 0; k < RF_LIGHT_CHILDREN; ++k )
    {
        double w = (double)weight[k];
        if ( w == 0.0 )
            continue;
        last = k;
        if ( rest < w )
            break;
        rest -= w;
    }
    double place = rest / (double)weight[last];
    *u = place < 0x1.fffffffffffffp-1 ? place : 0x1.fffffffffffffp-1;
    return last;
}

static RfLightPick pick_by_power( const RfLights* lights, const uint32_t bits[2] )
{
    uint32_t number = rf_pick_light_by_power( lights, bits[0], bits[1] );
    return ( RfLightPick ){ number, lights->share[number] };
}

static RfLightPick pick_by_tree( const RfLights* lights, RfVec3 x, RfVec3 n, double u )
{
    const RfLightTree* tree = &lights->tree;
    x = in_ball( lights, x );
    float weight[RF_LIGHT_CHILDREN];
    rf_weigh_lights( tree->nodes, x, n, weight );
    double sum = sum_of( weight ), sky = (double)weigh_sky( lights, n ), all = sum + sky;
    if ( !( all > 0.0 ) )
        return ( RfLightPick ){ RF_NO_LIGHT, 0.0f };
    if ( u * all < sky || sum == 0.0 )
        return ( RfLightPick ){ lights->count - 1, (float)( sky / all ) };
    u = ( u * all - sky ) / sum;
    double chance = sum / all;
    for ( const RfLightNode* node = tree->nodes;; )
    {
        int k = pick_child( weight, sum, &u );
        chance *= (double)weight[k] / sum;
        uint32_t child = node->child[k];
        if ( child & RF_LIGHT_LEAF )
            return ( RfLightPick ){ child & ~RF_LIGHT_LEAF, (float)chance };
        node = tree->nodes + child;
        rf_weigh_lights( node, x, n, weight );
        sum = sum_of( weight );
        if ( !( sum > 0.0 ) )
            return ( RfLightPick ){ RF_NO_LIGHT, 0.0f }; // bounds promised more than there is
    }
}

RfLightPick rf_pick_light( const RfLights* lights, RfLightPicking picking, RfVec3 x, RfVec3 n, const uint32_t bits[2] )
{
    if ( picking == RF_PICK_BY_POWER || lights->tree.node_count == 0 )
        return pick_by_power( lights, bits );
    // 53 bits: a light in millions leaves enough of them for those next to it
    double u = (double)( (uint64_t)bits[0] << 21 | bits[1] >> 11 ) * 0x1p-53;
    return pick_by_tree( lights, x, n, u );
}

float rf_light_chance( const RfLights* lights, RfLightPicking picking, uint32_t light, RfVec3 x, RfVec3 n )
{
    const RfLightTree* tree = &lights->tree;
    if ( picking == RF_PICK_BY_POWER || tree->node_count == 0 )
        return lights->share[light];
    float weight[RF_LIGHT_CHILDREN];
    double sky = (double)weigh_sky( lights, n );
    bool is_sky = rf_has_sky( lights ) && light == lights->count - 1;
    x = in_ball( lights, x );
    double chance = 1.0;
    // from the leaf up
    for ( uint32_t place = is_sky ? 0 : tree->place[light];; )
    {
        uint32_t number = place / RF_LIGHT_CHILDREN;
        rf_weigh_lights( tree->nodes + number, x, n, weight );
        double sum = sum_of( weight ) + ( number == 0 ? sky : 0.0 );
        double part = is_sky ? sky : (double)weight[place % RF_LIGHT_CHILDREN];
        if ( !( part > 0.0 ) )
            return 0.0f;
        chance *= part / sum;
        if ( number == 0 )
            return (float)chance;
        place = tree->node_place[number];
    }
}
