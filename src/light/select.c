// Selects a light at a shading point by descent of the light tree or by power; blocks of points descend level by level.
#include "base/fault.h"
#include "light/light.h"

#define SELECT_BLOCK 64 // below 256
#define BELOW_ONE ( 1.0 - 0x1p-52 )

// x in the coordinates of the tree, whose unit is the radius of the ball around the scene.
static RfVec3 in_ball( const RfLights* lights, RfVec3 x )
{
    return rf_scale( rf_sub( x, lights->center ), lights->inverse_radius );
}

static float sky_importance( const RfLights* lights, RfVec3 n )
{
    return rf_has_sky( lights ) ? rf_sky_irradiance_estimate( &lights->sky, n ) * lights->sky_scale : 0.0f;
}

// Importances of a node's children, and their prefix sums. Those are in doubles:
// in floats a child with a millionth of the sum would not be selected as often as
// its importance says.
typedef struct Importances
{
    float of[RF_LIGHT_CHILDREN];
    double before[RF_LIGHT_CHILDREN + 1]; // the last is the sum
} Importances;

static inline double find_importances( const RfLightNode* node, RfVec3 x, RfVec3 n, Importances* out )
{
    rf_light_importance( node, x, n, out->of );
    double sum = out->before[0] = 0.0;
    for ( int k = 0; k < RF_LIGHT_CHILDREN; ++k )
        out->before[k + 1] = sum = RF_FAULT( importance_sums ) ? (double)( (float)sum + out->of[k] ) : sum + (double)out->of[k];
    return sum;
}

// The state of a descent.
typedef struct Descent
{
    double u;           // in [0, 1), uniform within the node
    double probability; // of reaching the node
    uint32_t node;
} Descent;

// Descends into the child that u falls into. Without branches, which no processor
// could predict. The sum of the importances must be above 0.
static inline void descend( Descent* d, const RfLightNode* node, const Importances* importances )
{
    double sum = importances->before[RF_LIGHT_CHILDREN], position = d->u * sum, last = sum * BELOW_ONE;
    position = position < last ? position : last;
    int k = 0;
    for ( int i = 1; i < RF_LIGHT_CHILDREN; ++i )
        k += position >= importances->before[i]; // skips children of importance 0 as well
    double importance = (double)importances->of[k], u = ( position - importances->before[k] ) / importance;
    d->u = u < BELOW_ONE ? u : BELOW_ONE;
    d->probability *= importance / sum;
    d->node = node->child[k];
}

static RfLightSelection select_by_power( const RfLights* lights, uint32_t column_bits, uint32_t threshold_bits )
{
    uint32_t number = rf_select_light_by_power( lights, column_bits, threshold_bits );
    return ( RfLightSelection ){ number, lights->power_fraction[number] };
}

// Stands for a descent that ended without a light.
#define NO_LEAF ( RF_LIGHT_LEAF | ( RF_NO_LIGHT & ~RF_LIGHT_LEAF ) )

static inline void stop( Descent* d )
{
    d->node = NO_LEAF;
    d->probability = 0.0;
}

static void take_sky( const RfLights* lights, double probability, Descent* d )
{
    d->node = RF_LIGHT_LEAF | ( lights->count - 1 );
    d->probability = probability;
}

// The importances of the roots of the two trees, in the unit of the sky's.
static double find_root( const RfLightTree* tree, float scale, RfVec3 x, RfVec3 n, Importances* importances )
{
    return tree->node_count > 0 ? (double)scale * find_importances( tree->nodes, x, n, importances ) : 0.0;
}

// The first step where some lights change: the sky competes with the roots of both trees. Returns the nodes of the tree that is
// gone into.
static const RfLightNode* descend_from_roots( const RfLights* lights, RfVec3 x, RfVec3 n, Descent* d )
{
    Importances still, changing;
    double of_still = find_root( &lights->tree, lights->tree_scale, x, n, &still ),
           of_changing = find_root( lights->second, lights->second_scale, x, n, &changing ),
           sky = (double)sky_importance( lights, n ), all = of_still + of_changing + sky, position = d->u * all - sky;
    if ( !( all > 0.0 ) )
        stop( d );
    else if ( position < 0.0 || of_still + of_changing == 0.0 )
        take_sky( lights, sky / all, d );
    else
    {
        bool second = of_changing > 0.0 && position >= of_still;
        d->u = second ? ( position - of_still ) / of_changing : position / of_still;
        d->probability = ( second ? of_changing : of_still ) / all;
        const RfLightNode* nodes = second ? lights->second->nodes : lights->tree.nodes;
        descend( d, nodes, second ? &changing : &still );
        return nodes;
    }
    return NULL;
}

// The first step: the sky competes with the root.
static inline void descend_from_root( const RfLights* lights, RfVec3 x, RfVec3 n, Descent* d )
{
    Importances importances;
    double sum = find_importances( lights->tree.nodes, x, n, &importances ), sky = (double)sky_importance( lights, n ),
           all = sum + sky;
    if ( !( all > 0.0 ) )
        stop( d );
    else if ( d->u * all < sky || sum == 0.0 )
        take_sky( lights, sky / all, d );
    else
    {
        d->u = ( d->u * all - sky ) / sum;
        d->probability = sum / all;
        descend( d, lights->tree.nodes, &importances );
    }
}

static inline void descend_one_level( const RfLightNode* nodes, RfVec3 x, RfVec3 n, Descent* d )
{
    const RfLightNode* node = nodes + d->node;
    Importances importances;
    if ( find_importances( node, x, n, &importances ) > 0.0 )
        descend( d, node, &importances );
    else
        stop( d ); // the bounds of the node were too generous
}

// 53 random bits: enough to select among millions of lights.
static inline Descent begin( uint32_t high, uint32_t low )
{
    return ( Descent ){ (double)( (uint64_t)high << 21 | low >> 11 ) * 0x1p-53, 1.0, 0 };
}

static inline RfLightSelection end( const Descent* d )
{
    uint32_t light = d->node == NO_LEAF ? RF_NO_LIGHT : d->node & ~RF_LIGHT_LEAF;
    return ( RfLightSelection ){ light, (float)d->probability };
}

static bool has_tree( const RfLights* lights, RfLightSampling sampling )
{
    return rf_calls_for( sampling != RF_LIGHTS_BY_POWER && ( lights->tree.node_count > 0 || lights->second != NULL ),
                         RF_EFFECT_LIGHT_TREE );
}

// Several descents at a time, level by level, so that the processor overlaps their memory accesses. `two`: there are two trees.
static inline __attribute__( ( always_inline ) ) void select_block( const RfLights* lights, bool two, int count,
                                                                    const float* const x[3], const float* const n[3],
                                                                    const uint32_t* const bits[2], int first,
                                                                    RfLightSelection* selection )
{
    Descent d[SELECT_BLOCK];
    RfVec3 position[SELECT_BLOCK], normal[SELECT_BLOCK];
    const RfLightNode* nodes[SELECT_BLOCK]; // where there are two
    uint8_t active[SELECT_BLOCK];
    int left = 0;
    for ( int i = 0; i < count; ++i )
    {
        int k = first + i;
        d[i] = begin( bits[0][k], bits[1][k] );
        position[i] = in_ball( lights, RF_GET3( x, k ) );
        normal[i] = RF_GET3( n, k );
        if ( two )
            nodes[i] = descend_from_roots( lights, position[i], normal[i], d + i );
        else
            descend_from_root( lights, position[i], normal[i], d + i );
        active[left] = (uint8_t)i;
        left += !( d[i].node & RF_LIGHT_LEAF );
    }
    while ( left > 0 )
    {
        int kept = 0;
        for ( int k = 0; k < left; ++k )
        {
            int i = active[k];
            descend_one_level( two ? nodes[i] : lights->tree.nodes, position[i], normal[i], d + i );
            active[kept] = (uint8_t)i;
            kept += !( d[i].node & RF_LIGHT_LEAF );
        }
        left = kept;
    }
    for ( int i = 0; i < count; ++i )
        selection[first + i] = end( d + i );
}

void rf_select_lights( const RfLights* lights, RfLightSampling sampling, int count, const float* const x[3],
                       const float* const n[3], const uint32_t* const bits[2], RfLightSelection* selection )
{
    for ( int first = 0; first < count && has_tree( lights, sampling ); first += SELECT_BLOCK )
    {
        int in_block = count - first < SELECT_BLOCK ? count - first : SELECT_BLOCK;
        if ( lights->second != NULL )
            select_block( lights, true, in_block, x, n, bits, first, selection );
        else
            select_block( lights, false, in_block, x, n, bits, first, selection );
    }
    if ( has_tree( lights, sampling ) )
        return;
    for ( int i = 0; i < count; ++i )
        selection[i] = select_by_power( lights, bits[0][i], bits[1][i] );
}

// By the two trees, from the leaf to the root of its tree.
static float probability_by_two( const RfLights* lights, uint32_t light, RfVec3 x, RfVec3 n )
{
    Importances importances;
    double sky = (double)sky_importance( lights, n ),
           of_still = find_root( &lights->tree, lights->tree_scale, x, n, &importances ),
           of_changing = find_root( lights->second, lights->second_scale, x, n, &importances ),
           all = sky + of_still + of_changing;
    if ( rf_has_sky( lights ) && light == lights->count - 1 )
        return all > 0.0 ? (float)( sky / all ) : 0.0f;
    bool second = lights->second->node_count > 0 && lights->second->leaf_slot[light] != RF_NO_LIGHT;
    const RfLightTree* tree = second ? lights->second : &lights->tree;
    uint32_t position = tree->node_count > 0 ? tree->leaf_slot[light] : RF_NO_LIGHT;
    double probability = position != RF_NO_LIGHT ? 1.0 : 0.0;
    while ( probability > 0.0 )
    {
        uint32_t number = position / RF_LIGHT_CHILDREN;
        double sum = find_importances( tree->nodes + number, x, n, &importances );
        double importance = (double)importances.of[position % RF_LIGHT_CHILDREN];
        probability *= importance > 0.0 ? importance / sum : 0.0;
        if ( number == 0 && probability > 0.0 )
            return (float)( probability * ( ( second ? of_changing : of_still ) / all ) );
        position = tree->parent_slot[number];
    }
    return 0.0f;
}

float rf_light_probability( const RfLights* lights, RfLightSampling sampling, uint32_t light, RfVec3 x, RfVec3 n )
{
    const RfLightTree* tree = &lights->tree;
    if ( !has_tree( lights, sampling ) )
        return lights->power_fraction[light];
    if ( lights->second != NULL )
        return probability_by_two( lights, light, in_ball( lights, x ), n );
    Importances importances;
    double sky = (double)sky_importance( lights, n );
    bool is_sky = rf_has_sky( lights ) && light == lights->count - 1;
    x = in_ball( lights, x );
    double probability = 1.0;
    // from the leaf to the root
    for ( uint32_t position = is_sky ? 0 : tree->leaf_slot[light];; )
    {
        uint32_t number = position / RF_LIGHT_CHILDREN;
        double sum = find_importances( tree->nodes + number, x, n, &importances ) + ( number == 0 ? sky : 0.0 );
        double importance = is_sky ? sky : (double)importances.of[position % RF_LIGHT_CHILDREN];
        if ( !( importance > 0.0 ) )
            return 0.0f;
        probability *= importance / sum;
        if ( number == 0 )
            return (float)probability;
        position = tree->parent_slot[number];
    }
}
