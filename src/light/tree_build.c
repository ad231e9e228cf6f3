// From the top down: a set of lights is cut in two where that costs least, its
// parts again, the costliest first, until a node is full; then each of them.
#include "light/tree_bounds.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define BINS 16
#define ONE_AXIS_FROM 2000   // lights: more are cut along their longest axis
#define CUT_IN_THE_MIDDLE 12 // from this depth on, so that no scene makes the tree deep
#define PI 3.14159265358979324
#define ROUNDING 1e-6 // what floats may be off, of sizes and coordinates

typedef struct Range
{
    uint32_t first, count;
    RfLightBounds bounds;
    double cost;
} Range;

typedef struct Builder
{
    RfTreeLight* lights;
    RfLightTree* tree;
} Builder;

static double middle_of( const RfTreeLight* light, int axis ) { return 0.5 * ( light->low[axis] + light->high[axis] ); }

static Range make_range( const Builder* builder, uint32_t first, uint32_t count )
{
    Range range = { first, count, rf_no_lights(), 0.0 };
    for ( uint32_t i = 0; i < count; ++i )
        rf_bound_both( &range.bounds, builder->lights + first + i );
    range.cost = rf_bounds_cost( &range.bounds );
    return range;
}

// Where a range is cut: what lies below along an axis comes first.
typedef struct Cut
{
    int axis;
    double low, scale; // bin = ( middle − low ) scale
    int bin;           // the first of the second part; 0: no cut
} Cut;

static int bin_of( const RfTreeLight* light, int axis, double low, double scale )
{
    int bin = (int)( ( middle_of( light, axis ) - low ) * scale );
    return bin < 0 ? 0 : ( bin >= BINS ? BINS - 1 : bin );
}

// The least cost of a cut between bins.
static double best_of_axis( const RfLightBounds* bin, int* best )
{
    double below[BINS], least = INFINITY;
    RfLightBounds sum = rf_no_lights();
    for ( int k = 0; k + 1 < BINS; ++k )
    {
        rf_bound_both( &sum, bin + k );
        below[k] = rf_bounds_cost( &sum );
    }
    sum = rf_no_lights();
    for ( int k = BINS - 1; k > 0; --k )
    {
        rf_bound_both( &sum, bin + k );
        double cost = below[k - 1] + rf_bounds_cost( &sum );
        if ( cost < least )
        {
            least = cost;
            *best = k;
        }
    }
    return least;
}

// The extent of the lights' middles.
static void find_extent( const RfTreeLight* lights, uint32_t count, double low[3], double high[3] )
{
    for ( int axis = 0; axis < 3; ++axis )
    {
        low[axis] = INFINITY;
        high[axis] = -INFINITY;
    }
    for ( uint32_t i = 0; i < count; ++i )
    {
        for ( int axis = 0; axis < 3; ++axis )
        {
            double middle = middle_of( lights + i, axis );
            low[axis] = middle < low[axis] ? middle : low[axis];
            high[axis] = middle > high[axis] ? middle : high[axis];
        }
    }
}

// The best cut along an axis, and its cost.
static double cut_along( const RfTreeLight* lights, uint32_t count, int axis, double low, double high, Cut* cut )
{
    *cut = ( Cut ){ axis, low, BINS / ( high - low ), 0 };
    if ( !( high > low ) || !isfinite( cut->scale ) )
        return INFINITY;
    RfLightBounds bin[BINS];
    for ( int k = 0; k < BINS; ++k )
        bin[k] = rf_no_lights();
    for ( uint32_t i = 0; i < count; ++i )
        rf_bound_both( bin + bin_of( lights + i, axis, low, cut->scale ), lights + i );
    return best_of_axis( bin, &cut->bin );
}

static Cut find_cut( const Builder* builder, const Range* range )
{
    const RfTreeLight* lights = builder->lights + range->first;
    double low[3], high[3], longest = 0.0, widest = 0.0, least = INFINITY;
    find_extent( lights, range->count, low, high );
    for ( int axis = 0; axis < 3; ++axis )
    {
        longest = fmax( longest, range->bounds.high[axis] - range->bounds.low[axis] );
        widest = fmax( widest, high[axis] - low[axis] );
    }
    Cut best = { 0 };
    for ( int axis = 0; axis < 3; ++axis )
    {
        if ( range->count > ONE_AXIS_FROM && high[axis] - low[axis] < widest )
            continue;
        Cut cut;
        // long boxes are rather cut across
        double factor = longest / ( range->bounds.high[axis] - range->bounds.low[axis] );
        double cost = cut_along( lights, range->count, axis, low[axis], high[axis], &cut ) * factor;
        if ( cut.bin > 0 && cost < least )
        {
            least = cost;
            best = cut;
        }
    }
    return best;
}

// Brings the lights of the first part to the front; returns how many there are.
static uint32_t part( const Builder* builder, const Range* range, Cut cut )
{
    RfTreeLight* lights = builder->lights + range->first;
    uint32_t first = 0;
    for ( uint32_t i = 0; i < range->count; ++i )
    {
        if ( bin_of( lights + i, cut.axis, cut.low, cut.scale ) >= cut.bin )
            continue;
        RfTreeLight swap = lights[i];
        lights[i] = lights[first];
        lights[first++] = swap;
    }
    return first;
}

// Cuts a range of two lights or more; the second part goes to `second`.
static void cut_range( const Builder* builder, int depth, Range* range, Range* second )
{
    Cut cut = depth < CUT_IN_THE_MIDDLE ? find_cut( builder, range ) : ( Cut ){ 0 };
    uint32_t count = cut.bin > 0 ? part( builder, range, cut ) : 0;
    if ( count == 0 || count == range->count )
        count = range->count / 2; // all in one place, or deep down
    uint32_t first = range->first, all = range->count;
    *range = make_range( builder, first, count );
    *second = make_range( builder, first + count, all - count );
}

// The costliest range that can be cut, or −1; without cost that of the most lights.
static int costliest( const Range* ranges, int count )
{
    int best = -1;
    for ( int k = 0; k < count; ++k )
    {
        if ( ranges[k].count < 2 )
            continue;
        if ( best < 0 || ranges[k].cost > ranges[best].cost ||
             ( ranges[k].cost == ranges[best].cost && ranges[k].count > ranges[best].count ) )
            best = k;
    }
    return best;
}

// Sizes grow by a little: rounding must not leave anything outside.
static void fill_child( RfLightNode* node, int k, const RfLightBounds* b )
{
    double half2 = 0.0, farthest = 0.0;
    for ( int i = 0; i < 3; ++i )
    {
        double middle = 0.5 * ( b->low[i] + b->high[i] ), half = 0.5 * ( b->high[i] - b->low[i] );
        half2 += half * half;
        farthest = fmax( farthest, fmax( fabs( b->low[i] ), fabs( b->high[i] ) ) );
        node->center[i][k] = (float)middle;
        node->axis[i][k] = (float)b->axis[i];
    }
    node->radius[k] = (float)( sqrt( half2 ) * ( 1.0 + ROUNDING ) + ROUNDING * fmax( 1.0, farthest ) );
    node->inverse_radius[k] = 1.0f / node->radius[k];
    node->flip[k] = b->two_sided ? -1.0f : 1.0f;
    double turn = acos( b->cos_spread ) + acos( b->cos_emission ) - 0.5 * PI;
    node->cos_turn[k] = (float)cos( turn );
    node->sin_turn[k] = (float)sin( turn );
    node->full[k] = turn > 0.0 ? (float)cos( turn ) : 2.0f;
    // of a narrow beam the axis itself is not far from its horizon
    double head_on = turn < 0.0 ? fmax( cos( turn ), 1e-3 ) : 1.0;
    node->intensity[k] = b->intensity > 0.0 ? (float)fmax( b->intensity / head_on, 1e-37 ) : 0.0f;
}

static bool add_node( RfLightTree* tree, uint32_t place, uint32_t* number )
{
    if ( tree->node_count == tree->node_room )
    {
        uint32_t room = tree->node_room > 0 ? 2 * tree->node_room : 8;
        RfLightNode* nodes = aligned_alloc( _Alignof( RfLightNode ), room * sizeof *nodes );
        uint32_t* places = malloc( room * sizeof *places );
        if ( nodes == NULL || places == NULL )
        {
            free( nodes );
            free( places );
            return false;
        }
        if ( tree->node_count > 0 )
        {
            memcpy( nodes, tree->nodes, tree->node_count * sizeof *nodes );
            memcpy( places, tree->node_place, tree->node_count * sizeof *places );
        }
        free( tree->nodes );
        free( tree->node_place );
        tree->nodes = nodes;
        tree->node_place = places;
        tree->node_room = room;
    }
    *number = tree->node_count++;
    memset( tree->nodes + *number, 0, sizeof *tree->nodes );
    tree->node_place[*number] = place;
    return true;
}

static bool build_node( const Builder* builder, const Range* whole, int depth, uint32_t place, uint32_t* number )
{
    RfLightTree* tree = builder->tree;
    Range ranges[RF_LIGHT_CHILDREN] = { *whole };
    int count = 1, next;
    while ( count < RF_LIGHT_CHILDREN && ( next = costliest( ranges, count ) ) >= 0 )
    {
        cut_range( builder, depth, ranges + next, ranges + count );
        ++count;
    }
    if ( !add_node( tree, place, number ) )
        return false;
    for ( int k = 0; k < count; ++k )
    {
        uint32_t here = *number * RF_LIGHT_CHILDREN + (uint32_t)k, child;
        fill_child( tree->nodes + *number, k, &ranges[k].bounds );
        if ( ranges[k].count == 1 )
        {
            uint32_t light = builder->lights[ranges[k].first].light;
            child = RF_LIGHT_LEAF | light;
            tree->place[light] = here;
        }
        else if ( !build_node( builder, ranges + k, depth + 1, here, &child ) )
            return false;
        tree->nodes[*number].child[k] = child; // the nodes may have moved
    }
    return true;
}

RfResult rf_build_light_tree( RfTreeLight* lights, uint32_t count, uint32_t numbers, RfLightTree* tree, RfError* error )
{
    *tree = ( RfLightTree ){ 0 };
    Builder builder = { lights, tree };
    tree->place = malloc( numbers * sizeof *tree->place );
    Range whole = make_range( &builder, 0, count );
    uint32_t root;
    if ( tree->place == NULL || !build_node( &builder, &whole, 0, 0, &root ) )
    {
        rf_destroy_light_tree( tree );
        return rf_fail( error, RF_ERROR_MEMORY, "no memory for a tree of %u lights", count );
    }
    return RF_OK;
}

void rf_destroy_light_tree( RfLightTree* tree )
{
    free( tree->nodes );
    free( tree->node_place );
    free( tree->place );
    *tree = ( RfLightTree ){ 0 };
}
