#include "light/light.h"

#define PICK_BLOCK 64 // below 256
#define BELOW_ONE ( 1.0 - 0x1p-52 )

// Where the tree has x: in units of the ball around the scene.
static RfVec3 in_ball( const RfLights* lights, RfVec3 x )
{
    return rf_scale( rf_sub( x, lights->center ), lights->inverse_radius );
}

static float weigh_sky( const RfLights* lights, RfVec3 n )
{
    return rf_has_sky( lights ) ? rf_sky_irradiance_estimate( &lights->sky, n ) * lights->sky_scale : 0.0f;
}

// Weights of a node's children and, summed in doubles, of those before each:
// in floats one of a millionth would not be met as often as its weight says.
typedef struct Weights
{
    float of[RF_LIGHT_CHILDREN];
    double before[RF_LIGHT_CHILDREN + 1]; // the last is the sum
} Weights;

static inline double weigh( const RfLightNode* node, RfVec3 x, RfVec3 n, Weights* out )
{
    rf_light_importance( node, x, n, out->of );
    double sum = out->before[0] = 0.0;
    for ( int k = 0; k < RF_LIGHT_CHILDREN; ++k )
        out->before[k + 1] = sum += (double)out->of[k];
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
static inline void descend( Descent* d, const RfLightNode* node, const Weights* weights )
{
    double sum = weights->before[RF_LIGHT_CHILDREN], place = d->u * sum, last = sum * BELOW_ONE;
    place = place < last ? place : last;
    int k = 0;
    for ( int i = 1; i < RF_LIGHT_CHILDREN; ++i )
        k += place >= weights->before[i]; // beyond those without weight, too
    double part = (double)weights->of[k], u = ( place - weights->before[k] ) / part;
    d->u = u < BELOW_ONE ? u : BELOW_ONE;
    d->chance *= part / sum;
    d->node = node->child[k];
}

static RfLightSelection pick_by_power( const RfLights* lights, uint32_t column_bits, uint32_t share_bits )
{
    uint32_t number = rf_select_light_by_power( lights, column_bits, share_bits );
    return ( RfLightSelection ){ number, lights->share[number] };
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
    Weights weights;
    double sum = weigh( lights->tree.nodes, x, n, &weights ), sky = (double)weigh_sky( lights, n ), all = sum + sky;
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
        descend( d, lights->tree.nodes, &weights );
    }
}

static inline void go_on( const RfLights* lights, RfVec3 x, RfVec3 n, Descent* d )
{
    const RfLightNode* node = lights->tree.nodes + d->node;
    Weights weights;
    if ( weigh( node, x, n, &weights ) > 0.0 )
        descend( d, node, &weights );
    else
        stop( d ); // its bounds promised more than there is
}

// 53 bits: a light in millions leaves enough of them for those next to it.
static inline Descent begin( uint32_t high, uint32_t low )
{
    return ( Descent ){ (double)( (uint64_t)high << 21 | low >> 11 ) * 0x1p-53, 1.0, 0 };
}

static inline RfLightSelection end( const Descent* d )
{
    uint32_t light = d->node == NOWHERE ? RF_NO_LIGHT : d->node & ~RF_LIGHT_LEAF;
    return ( RfLightSelection ){ light, (float)d->chance };
}

static bool has_tree( const RfLights* lights, RfLightSampling picking )
{
    return picking != RF_LIGHTS_BY_POWER && lights->tree.node_count > 0;
}

RfLightSelection rf_select_light( const RfLights* lights, RfLightSampling picking, RfVec3 x, RfVec3 n, const uint32_t bits[2] )
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
                        const uint32_t* const bits[2], int first, RfLightSelection* pick )
{
    Descent d[PICK_BLOCK];
    RfVec3 place[PICK_BLOCK], normal[PICK_BLOCK];
    uint8_t active[PICK_BLOCK];
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

void rf_select_lights( const RfLights* lights, RfLightSampling picking, int count, const float* const x[3],
                       const float* const n[3], const uint32_t* const bits[2], RfLightSelection* pick )
{
    if ( has_tree( lights, picking ) )
    {
        for ( int first = 0; first < count; first += PICK_BLOCK )
            pick_block( lights, count - first < PICK_BLOCK ? count - first : PICK_BLOCK, x, n, bits, first, pick );
        return;
    }
    for ( int i = 0; i < count; ++i )
        pick[i] = pick_by_power( lights, bits[0][i], bits[1][i] );
}

float rf_light_probability( const RfLights* lights, RfLightSampling picking, uint32_t light, RfVec3 x, RfVec3 n )
{
    const RfLightTree* tree = &lights->tree;
    if ( !has_tree( lights, picking ) )
        return lights->share[light];
    Weights weights;
    double sky = (double)weigh_sky( lights, n );
    bool is_sky = rf_has_sky( lights ) && light == lights->count - 1;
    x = in_ball( lights, x );
    double chance = 1.0;
    // from the leaf up
    for ( uint32_t place = is_sky ? 0 : tree->place[light];; )
    {
        uint32_t number = place / RF_LIGHT_CHILDREN;
        double sum = weigh( tree->nodes + number, x, n, &weights ) + ( number == 0 ? sky : 0.0 );
        double part = is_sky ? sky : (double)weights.of[place % RF_LIGHT_CHILDREN];
        if ( !( part > 0.0 ) )
            return 0.0f;
        chance *= part / sum;
        if ( number == 0 )
            return (float)chance;
        place = tree->node_place[number];
    }
}
