// Builds the light tree top-down by the surface area orientation heuristic over bins, and weighs nodes at a point.
#include "light/tree.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979324

// The bounds of a set of lights: a box, an orientation cone, and the sum of their
// intensities (Conty Estevez, Kulla 2018, section 4). An RfTreeLight is the bounds of a
// single light. The box of an empty set has low > high.
typedef RfTreeLight RfLightBounds;

static RfLightBounds no_lights( void )
{
    return ( RfLightBounds ){ .low = { INFINITY, INFINITY, INFINITY }, .high = { -INFINITY, -INFINITY, -INFINITY } };
}

static bool is_empty( const RfLightBounds* b ) { return b->low[0] > b->high[0]; }

static double dot( const double a[3], const double b[3] ) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static double angle_of( double cosine ) { return acos( cosine > 1.0 ? 1.0 : ( cosine < -1.0 ? -1.0 : cosine ) ); }

static void face_everywhere( RfLightBounds* a )
{
    a->cos_spread = -1.0;
    a->two_sided = false;
}

static void take_cone( RfLightBounds* a, const RfLightBounds* b )
{
    for ( int i = 0; i < 3; ++i )
        a->axis[i] = b->axis[i];
    a->cos_spread = b->cos_spread;
    a->two_sided = b->two_sided;
}

// Rotates the axis by `turn` towards the unit vector b; `angle` is between them.
static void turn_axis( double axis[3], const double b[3], double angle, double turn )
{
    if ( !( sin( angle ) > 0.0 ) )
        return;
    double sum = 0.0, from = sin( angle - turn ) / sin( angle ), to = sin( turn ) / sin( angle );
    for ( int i = 0; i < 3; ++i )
    {
        axis[i] = from * axis[i] + to * b[i];
        sum += axis[i] * axis[i];
    }
    for ( int i = 0; i < 3; ++i )
        axis[i] /= sqrt( sum );
}

// The union of two cones; those of two-sided lights are double cones.
static void unite_cones( RfLightBounds* a, const RfLightBounds* b )
{
    double cos_angle = dot( a->axis, b->axis );
    bool flip = a->two_sided && b->two_sided && cos_angle < 0.0;
    cos_angle = flip ? -cos_angle : cos_angle;
    if ( cos_angle >= 1.0 - 1e-14 && a->cos_spread == b->cos_spread && a->two_sided == b->two_sided )
        return;
    if ( b->cos_spread == 1.0 && cos_angle >= a->cos_spread && a->two_sided == b->two_sided )
        return; // a single direction inside the cone
    double other[3] = { flip ? -b->axis[0] : b->axis[0], flip ? -b->axis[1] : b->axis[1], flip ? -b->axis[2] : b->axis[2] };
    double angle = angle_of( cos_angle ), spread_a = angle_of( a->cos_spread ), spread_b = angle_of( b->cos_spread );
    double spread = 0.5 * ( spread_a + angle + spread_b );
    if ( a->two_sided != b->two_sided )
        face_everywhere( a ); // NOLINT(bugprone-branch-clone): as further down, but the order matters
    else if ( angle + spread_b <= spread_a )
        return;
    else if ( angle + spread_a <= spread_b )
        take_cone( a, b );
    else if ( spread >= PI || cos_angle < -1.0 + 1e-9 )
        face_everywhere( a );
    else
    {
        turn_axis( a->axis, other, angle, spread - spread_a );
        a->cos_spread = cos( spread );
    }
}

static void bound_both( RfLightBounds* a, const RfLightBounds* b )
{
    if ( is_empty( b ) )
        return;
    if ( is_empty( a ) )
    {
        *a = *b;
        return;
    }
    for ( int i = 0; i < 3; ++i )
    {
        a->low[i] = fmin( a->low[i], b->low[i] );
        a->high[i] = fmax( a->high[i], b->high[i] );
    }
    a->intensity += b->intensity;
    a->cos_emission = fmin( a->cos_emission, b->cos_emission );
    unite_cones( a, b );
}

void rf_sweep_tree_light( RfTreeLight* light, const RfTreeLight* other )
{
    double most = fmax( light->intensity, other->intensity );
    if ( !( other->intensity > 0.0 ) )
        return;
    if ( light->intensity > 0.0 )
        bound_both( light, other );
    else
        *light = *other;
    light->intensity = most;
}

// The solid angle that the cone lights, weighted by the cosine beyond the spread.
static double measure_of_directions( const RfLightBounds* b )
{
    double spread = angle_of( b->cos_spread ), reach = fmin( spread + angle_of( b->cos_emission ), PI );
    double s = sin( spread ), c = b->cos_spread;
    double one = 2.0 * PI * ( 1.0 - c ) + 0.5 * PI * ( 2.0 * reach * s - cos( spread - 2.0 * reach ) - 2.0 * spread * s + c );
    return b->two_sided ? fmin( 2.0 * one, 4.0 * PI ) : one;
}

// The surface area orientation heuristic: intensity times the measure of the lit
// directions times the squared diagonal of the box, which takes the place of the
// area since it is above 0 for lights along a line.
static double bounds_cost( const RfLightBounds* b )
{
    if ( is_empty( b ) )
        return 0.0;
    double diagonal2 = 0.0;
    for ( int i = 0; i < 3; ++i )
        diagonal2 += ( b->high[i] - b->low[i] ) * ( b->high[i] - b->low[i] );
    return b->intensity * measure_of_directions( b ) * diagonal2;
}

// Top-down construction: a set of lights is split in two where that costs least,
// then its most expensive part, until the node is full; each part becomes a child.

#define BINS 16
#define ONE_AXIS_FROM 2000     // lights: larger sets are split along their longest axis only
#define SPLIT_BY_COUNT_FROM 12 // depth from which sets are halved by count, which bounds the depth of the tree
#define ROUNDING 1e-6          // relative rounding error of floats, with margin

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

static double centre_of( const RfTreeLight* light, int axis ) { return 0.5 * ( light->low[axis] + light->high[axis] ); }

static Range make_range( const Builder* builder, uint32_t first, uint32_t count )
{
    Range range = { first, count, no_lights(), 0.0 };
    for ( uint32_t i = 0; i < count; ++i )
        bound_both( &range.bounds, builder->lights + first + i );
    range.cost = bounds_cost( &range.bounds );
    return range;
}

// How a range is split: lights below the plane come first.
typedef struct Split
{
    int axis;
    double low, scale; // bin = ( centre − low ) scale
    int bin;           // the first bin of the second part; 0: no split
} Split;

static int bin_of( const RfTreeLight* light, int axis, double low, double scale )
{
    int bin = (int)( ( centre_of( light, axis ) - low ) * scale );
    return bin < 0 ? 0 : ( bin >= BINS ? BINS - 1 : bin );
}

// The lowest cost of a split between bins. Most sets are small, and most bins empty: behind those nothing costs anything else.
static double best_split_of_axis( const RfLightBounds* bin, int* best )
{
    double below[BINS], least = INFINITY, cost = 0.0;
    RfLightBounds sum = no_lights();
    for ( int k = 0; k + 1 < BINS; ++k )
    {
        if ( !is_empty( bin + k ) )
        {
            bound_both( &sum, bin + k );
            cost = bounds_cost( &sum );
        }
        below[k] = cost;
    }
    sum = no_lights();
    cost = 0.0;
    for ( int k = BINS - 1; k > 0; --k )
    {
        if ( !is_empty( bin + k ) )
        {
            bound_both( &sum, bin + k );
            cost = bounds_cost( &sum );
        }
        if ( below[k - 1] + cost < least )
        {
            least = below[k - 1] + cost;
            *best = k;
        }
    }
    return least;
}

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
            double centre = centre_of( lights + i, axis );
            low[axis] = centre < low[axis] ? centre : low[axis];
            high[axis] = centre > high[axis] ? centre : high[axis];
        }
    }
}

// The best split along an axis; returns its cost.
static double split_along( const RfTreeLight* lights, uint32_t count, int axis, double low, double high, Split* split )
{
    *split = ( Split ){ axis, low, 0.0, 0 };
    if ( !( high > low ) || !isfinite( BINS / ( high - low ) ) )
        return INFINITY;
    split->scale = BINS / ( high - low );
    RfLightBounds bin[BINS];
    for ( int k = 0; k < BINS; ++k )
        bin[k] = no_lights();
    for ( uint32_t i = 0; i < count; ++i )
        bound_both( bin + bin_of( lights + i, axis, low, split->scale ), lights + i );
    return best_split_of_axis( bin, &split->bin );
}

static Split find_split( const Builder* builder, const Range* range )
{
    const RfTreeLight* lights = builder->lights + range->first;
    double low[3], high[3], longest = 0.0, widest = 0.0, least = INFINITY;
    find_extent( lights, range->count, low, high );
    for ( int axis = 0; axis < 3; ++axis )
    {
        longest = fmax( longest, range->bounds.high[axis] - range->bounds.low[axis] );
        widest = fmax( widest, high[axis] - low[axis] );
    }
    Split best = { 0 };
    for ( int axis = 0; axis < 3; ++axis )
    {
        if ( range->count > ONE_AXIS_FROM && high[axis] - low[axis] < widest )
            continue;
        Split split;
        // prefers to split long boxes across
        double cost = split_along( lights, range->count, axis, low[axis], high[axis], &split );
        double extent = range->bounds.high[axis] - range->bounds.low[axis]; // above 0 where there is a split
        if ( split.bin > 0 && cost * ( longest / extent ) < least )
        {
            least = cost * ( longest / extent );
            best = split;
        }
    }
    return best;
}

// Moves the lights of the first part to the front; returns how many there are.
static uint32_t partition( const Builder* builder, const Range* range, Split split )
{
    RfTreeLight* lights = builder->lights + range->first;
    uint32_t first = 0;
    for ( uint32_t i = 0; i < range->count; ++i )
    {
        if ( bin_of( lights + i, split.axis, split.low, split.scale ) >= split.bin )
            continue;
        RfTreeLight swap = lights[i];
        lights[i] = lights[first];
        lights[first++] = swap;
    }
    return first;
}

// Splits a range of at least two lights; the second part goes to `second`.
static void split_range( const Builder* builder, int depth, Range* range, Range* second )
{
    Split split = depth < SPLIT_BY_COUNT_FROM ? find_split( builder, range ) : ( Split ){ 0 };
    uint32_t count = split.bin > 0 ? partition( builder, range, split ) : 0;
    if ( count == 0 || count == range->count )
        count = range->count / 2; // all at one point, or too deep
    uint32_t first = range->first, all = range->count;
    *range = make_range( builder, first, count );
    *second = make_range( builder, first + count, all - count );
}

// The most expensive range that can be split, or −1; ties go to the one with more lights.
static int most_expensive( const Range* ranges, int count )
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

// Sizes grow a little, so that rounding leaves nothing outside.
static void fill_child( RfLightNode* node, int k, const RfLightBounds* b )
{
    double half2 = 0.0, largest = 0.0;
    for ( int i = 0; i < 3; ++i )
    {
        double centre = 0.5 * ( b->low[i] + b->high[i] ), half = 0.5 * ( b->high[i] - b->low[i] );
        half2 += half * half;
        largest = fmax( largest, fmax( fabs( b->low[i] ), fabs( b->high[i] ) ) );
        node->center[i][k] = (float)centre;
        node->axis[i][k] = (float)b->axis[i];
    }
    node->radius[k] = (float)( sqrt( half2 ) * ( 1.0 + ROUNDING ) + ROUNDING * fmax( 1.0, largest ) );
    node->inverse_radius[k] = 1.0f / node->radius[k];
    node->flip[k] = b->two_sided ? -1.0f : 1.0f;
    double turn = acos( b->cos_spread ) + acos( b->cos_emission ) - 0.5 * PI;
    node->cos_turn[k] = (float)cos( turn );
    node->sin_turn[k] = (float)sin( turn );
    node->full[k] = turn > 0.0 ? (float)cos( turn ) : 2.0f;
    // in a narrow beam even the axis is close to the horizon
    double head_on = turn < 0.0 ? fmax( cos( turn ), 1e-3 ) : 1.0;
    node->intensity[k] = b->intensity > 0.0 ? (float)fmax( b->intensity / head_on, 1e-37 ) : 0.0f;
}

static bool add_node( RfLightTree* tree, uint32_t slot, uint32_t* number )
{
    if ( tree->node_count == tree->node_capacity )
    {
        uint32_t capacity = tree->node_capacity > 0 ? 2 * tree->node_capacity : 8;
        RfLightNode* nodes = aligned_alloc( _Alignof( RfLightNode ), capacity * sizeof *nodes );
        uint32_t* slots = malloc( capacity * sizeof *slots );
        if ( nodes == NULL || slots == NULL )
        {
            free( nodes );
            free( slots );
            return false;
        }
        if ( tree->node_count > 0 )
        {
            memcpy( nodes, tree->nodes, tree->node_count * sizeof *nodes );
            memcpy( slots, tree->parent_slot, tree->node_count * sizeof *slots );
        }
        free( tree->nodes );
        free( tree->parent_slot );
        tree->nodes = nodes;
        tree->parent_slot = slots;
        tree->node_capacity = capacity;
    }
    *number = tree->node_count++;
    memset( tree->nodes + *number, 0, sizeof *tree->nodes );
    tree->parent_slot[*number] = slot;
    return true;
}

static bool build_node( const Builder* builder, const Range* all, int depth, uint32_t slot, uint32_t* number )
{
    RfLightTree* tree = builder->tree;
    Range ranges[RF_LIGHT_CHILDREN] = { *all };
    int count = 1, next;
    while ( count < RF_LIGHT_CHILDREN && ( next = most_expensive( ranges, count ) ) >= 0 )
    {
        split_range( builder, depth, ranges + next, ranges + count );
        ++count;
    }
    if ( !add_node( tree, slot, number ) )
        return false;
    for ( int k = 0; k < count; ++k )
    {
        uint32_t here = *number * RF_LIGHT_CHILDREN + (uint32_t)k, child;
        fill_child( tree->nodes + *number, k, &ranges[k].bounds );
        if ( ranges[k].count == 1 )
        {
            uint32_t light = builder->lights[ranges[k].first].light;
            child = RF_LIGHT_LEAF | light;
            tree->leaf_slot[light] = here;
        }
        else if ( !build_node( builder, ranges + k, depth + 1, here, &child ) )
            return false;
        tree->nodes[*number].child[k] = child; // the nodes may have been reallocated
    }
    return true;
}

RfResult rf_build_light_tree( RfTreeLight* lights, uint32_t count, uint32_t numbers, RfLightTree* tree, RfError* error )
{
    *tree = ( RfLightTree ){ 0 };
    Builder builder = { lights, tree };
    tree->leaf_slot = malloc( numbers * sizeof *tree->leaf_slot );
    if ( tree->leaf_slot != NULL )
        memset( tree->leaf_slot, 0xff, numbers * sizeof *tree->leaf_slot ); // RF_NO_LIGHT
    Range all = make_range( &builder, 0, count );
    uint32_t root;
    if ( tree->leaf_slot == NULL || !build_node( &builder, &all, 0, 0, &root ) )
    {
        rf_destroy_light_tree( tree );
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for a tree of %u lights", count );
    }
    return RF_OK;
}

void rf_destroy_light_tree( RfLightTree* tree )
{
    free( tree->nodes );
    free( tree->parent_slot );
    free( tree->leaf_slot );
    *tree = ( RfLightTree ){ 0 };
}

#define SLACK 1e-3f  // tolerance of cosines: only a light below −SLACK is certain to be under a horizon
#define LEAST 1e-37f // smallest importance of a child that can contribute

// How much the radius of a ball adds to the cosines of its centre: little noise in halls
// of 10 to 1000 lamps.
#define WIDTH 0.2f

void rf_light_importance( const RfLightNode* node, RfVec3 x, RfVec3 n, float importance[RF_LIGHT_CHILDREN] )
{
    const float *cx = node->center[0], *cy = node->center[1], *cz = node->center[2];
    const float *radius = node->radius, *inverse_radius = node->inverse_radius;
    const float *ax = node->axis[0], *ay = node->axis[1], *az = node->axis[2], *flip = node->flip;
    const float *cos_turn = node->cos_turn, *sin_turn = node->sin_turn, *full = node->full, *intensity = node->intensity;
    float* restrict out = importance;
#pragma omp simd
    for ( int k = 0; k < RF_LIGHT_CHILDREN; ++k )
    {
        float dx = cx[k] - x.x, dy = cy[k] - x.y, dz = cz[k] - x.z;
        float d2 = dx * dx + dy * dy + dz * dz;
        float inverse = 1.0f / sqrtf( rf_maxf( d2, 1e-30f ) );
        // sine of the half angle of the ball as seen from x; inside, it covers everything
        float sin_ball = rf_minf( radius[k] * inverse, 1.0f );
        // cosines at the centre of the ball: of emission, and at x
        float along = -( ax[k] * dx + ay[k] * dy + az[k] * dz ) * inverse;
        along = rf_maxf( along, along * flip[k] );
        float across = sqrtf( rf_maxf( 1.0f - along * along, 0.0f ) );
        float turned = along * cos_turn[k] + across * sin_turn[k];
        float cos_light = along > full[k] ? 1.0f : turned;
        float cos_x = ( n.x * dx + n.y * dy + n.z * dz ) * inverse;
        // if both are above −sin_ball, some of the ball may be above both horizons
        float arrives = rf_minf( rf_minf( cos_light, cos_x ) + sin_ball + SLACK, intensity[k] );
        float spread = WIDTH * sin_ball + SLACK;
        cos_light = rf_maxf( cos_light, 0.0f ) + spread;
        cos_x = rf_maxf( cos_x, 0.0f ) + spread;
        float near = rf_minf( inverse, inverse_radius[k] ); // no nearer than its radius
        float w = rf_maxf( intensity[k] * cos_light * cos_x * ( near * near ), LEAST );
        out[k] = arrives > 0.0f ? w : 0.0f;
    }
}
