#include "light/light.h"

#define RF_PICK_BLOCK 64 // below 256

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

// A pick on its way down the tree.
typedef struct Descent
{
    double u;      // in [0, 1): the place within the node
    double chance; // of the node
    uint32_t node;
} Descent;

// Goes on to the child in which u lies. Without branches: which child it is, no
// processor foretells. The sum of the weights is above 0.
static inline void descend( Descent* d, const RfLightNode* node, const float weight[RF_LIGHT_CHILDREN], double sum )
{
    double place = d->u * sum, below = 0.0, to = 0.0;
    double last = sum * ( 1.0 - 0x1p-52 );
    place = place < last ? place : last;
    uint32_t k = 0;
    for ( int i = 0; i < RF_LIGHT_CHILDREN; ++i )
    {
        to += (double)weight[i];
        uint32_t beyond = place >= to; // of those without weight, too
        k += beyond;
        below = beyond ? to : below;
    }
    double part = (double)weight[k];
    double u = ( place - below ) / part;
    d->u = u < 1.0 - 0x1p-52 ? u : 1.0 - 0x1p-52;
    d->chance *= part / sum;
    d->node = node->child[k];
}

static RfLightPick pick_by_power( const RfLights* lights, uint32_t column_bits, uint32_t share_bits )
{
    uint32_t number = rf_pick_light_by_power( lights, column_bits, share_bits );
    return ( RfLightPick ){ number, lights->share[number] };
}

// Where there is nothing to descend into, a leaf of no light.
#define NOWHERE ( RF_LIGHT_LEAF | ( RF_NO_LIGHT & ~RF_LIGHT_LEAF ) )

static inline void stop( Descent* d )
{
    d->node = NOWHERE;
    d->chance = 0.0;
}

// From the root, beside which there is the sky.
static inline void set_off( const RfLights* lights, RfVec3 x, RfVec3 n, Descent* d )
{
    float weight[RF_LIGHT_CHILDREN];
    rf_weigh_lights( lights->tree.nodes, x, n, weight );
    double sum = sum_of( weight ), sky = (double)weigh_sky( lights, n ), all = sum + sky;
    if ( !( all > 0.0 ) )
        stop( d );
    else if ( d->u * all < sky || sum == 0.0 )
    {
        d->node = RF_LIGHT_LEAF | ( lights->count - 1 );
        d->chance = sky / all;
    }
    else
    {
        d->u = ( d->u * all - sky ) / sum;
        d->chance = sum / all;
        descend( d, lights->tree.nodes, weight, sum );
    }
}

static inline void go_on( const RfLights* lights, RfVec3 x, RfVec3 n, Descent* d )
{
    const RfLightNode* node = lights->tree.nodes + d->node;
    float weight[RF_LIGHT_CHILDREN];
    rf_weigh_lights( node, x, n, weight );
    double sum = sum_of( weight );
    if ( sum > 0.0 )
        descend( d, node, weight, sum );
    else
        stop( d ); // its bounds promised more than there is
}

// 53 bits: a light in millions leaves enough of them for those next to it.
static inline Descent begin( uint32_t high, uint32_t low )
{
    return ( Descent ){ (double)( (uint64_t)high << 21 | low >> 11 ) * 0x1p-53, 1.0, 0 };
}

static inline RfLightPick end( const Descent* d )
{
    uint32_t light = d->node == NOWHERE ? RF_NO_LIGHT : d->node & ~RF_LIGHT_LEAF;
    return ( RfLightPick ){ light, (float)d->chance };
}

static bool has_tree( const RfLights* lights, RfLightPicking picking )
{
    return picking != RF_PICK_BY_POWER && lights->tree.node_count > 0;
}

RfLightPick rf_pick_light( const RfLights* lights, RfLightPicking picking, RfVec3 x, RfVec3 n, const uint32_t bits[2] )
{
    if ( !has_tree( lights, picking ) )
        return pick_by_power( lights, bits[0], bits[1] );
    Descent d = begin( bits[0], bits[1] );
    x = in_ball( lights, x );
    set_off( lights, x, n, &d );
    while ( !( d.node & RF_LIGHT_LEAF ) )
        go_on( lights, x, n, &d );
    return end( &d );
}

// A few at a time, level by level: the processor works at several of them at once.
static void pick_block( const RfLights* lights, int count, const float* const x[3], const float* const n[3],
                        const uint32_t* const bits[2], int first, RfLightPick* pick )
{
    Descent d[RF_PICK_BLOCK];
    RfVec3 place[RF_PICK_BLOCK], normal[RF_PICK_BLOCK];
    uint8_t active[RF_PICK_BLOCK];
    int left = 0;
    for ( int i = 0; i < count; ++i )
    {
        int k = first + i;
        d[i] = begin( bits[0][k], bits[1][k] );
        place[i] = in_ball( lights, rf_vec3( x[0][k], x[1][k], x[2][k] ) );
        normal[i] = rf_vec3( n[0][k], n[1][k], n[2][k] );
        set_off( lights, place[i], normal[i], d + i );
        active[left] = (uint8_t)i;
        left += !( d[i].node & RF_LIGHT_LEAF );
    }
    while ( left > 0 )
    {
        int kept = 0;
        for ( int k = 0; k < left; ++k )
        {
            int i = active[k];
            go_on( lights, place[i], normal[i], d + i );
            active[kept] = (uint8_t)i;
            kept += !( d[i].node & RF_LIGHT_LEAF );
        }
        left = kept;
    }
    for ( int i = 0; i < count; ++i )
        pick[first + i] = end( d + i );
}

void rf_pick_lights( const RfLights* lights, RfLightPicking picking, int count, const float* const x[3],
                     const float* const n[3], const uint32_t* const bits[2], RfLightPick* pick )
{
    if ( has_tree( lights, picking ) )
    {
        for ( int first = 0; first < count; first += RF_PICK_BLOCK )
            pick_block( lights, count - first < RF_PICK_BLOCK ? count - first : RF_PICK_BLOCK, x, n, bits, first, pick );
        return;
    }
    for ( int i = 0; i < count; ++i )
        pick[i] = pick_by_power( lights, bits[0][i], bits[1][i] );
}

float rf_light_chance( const RfLights* lights, RfLightPicking picking, uint32_t light, RfVec3 x, RfVec3 n )
{
    const RfLightTree* tree = &lights->tree;
    if ( !has_tree( lights, picking ) )
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
