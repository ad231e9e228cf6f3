// Learns densities of directions from what paths have found.
#include "path/guide_learner.h"

#include <stdlib.h>
#include <string.h>

#define LEAF 2000         // samples, at least, and fewer than four times as many
#define LEAST_LIT 16      // with light, else nothing is learned
#define FEW 8             // with light: a node of a quadtree with fewer has no quarters
#define EQUAL 32.0        // samples that the assumption of equal quarters counts for
#define LEAST_PART 0.125f // of the samples of a node, that either half of it must have
#define MOST_LIGHT 1e18f  // of a sample: sums of larger ones would overflow
#define LEVELS 6          // of a quadtree
#define SHARES 5
static const float s_shares[SHARES] = { 0.0f, 0.25f, 0.5f, 0.75f, 0.875f };

_Static_assert( 1 << ( LEVELS - 1 ) == RF_GUIDE_SIDE, "the last level of a quadtree has the bins" );

// ---- Samples

void rf_clear_guide_notes( int count, RfGuideNotes* notes ) { memset( notes->count, 0, (size_t)count * sizeof *notes->count ); }

static float found_by( const RfWavefront* wavefront, int slot )
{
    return rf_luminance( RF_GET3( wavefront->arrivals.rest, slot ) );
}

void rf_note_vertices( const RfWavefront* wavefront, const RfRayLanes* rays, const RfRayLanes* next, int count,
                       RfGuideNotes* notes )
{
    const RfVertexLanes* v = &wavefront->vertices;
    int32_t lane[RF_LANES];
    for ( int i = 0; i < rf_record_count( v ); ++i )
        lane[v->slot[i]] = i;
    for ( int r = 0; r < count; ++r )
    {
        int slot = next->slot[r], i = lane[slot];
        if ( notes->count[slot] == RF_MOST_NOTED || i >= rf_first_sided( v ) )
            continue;
        RfVec3 d = RF_GET3( next->d, r ), n = RF_GET3( v->n, i );
        RfNotedVertex* noted = &notes->vertex[slot][notes->count[slot]++];
        RfGuideSample* s = &noted->sample;
        *noted = ( RfNotedVertex ){ .cosine = rf_dot( n, d ),
                                    .throughput = rf_luminance( RF_GET3( next->throughput, r ) ),
                                    .before = rf_luminance( RF_GET3( rays->throughput, v->ray[i] ) ),
                                    .found = found_by( wavefront, slot ) };
        for ( int c = 0; c < 3; ++c )
            s->p[c] = v->p[c][i];
        s->pdf_solid_angle = next->pdf_solid_angle[r];
        s->pdf_bsdf = v->guide != NULL ? wavefront->scratch.pdf_bsdf[i] : s->pdf_solid_angle;
        s->bin = (int16_t)rf_guide_bin( d, &s->per_solid_angle );
        s->axis = (uint8_t)rf_guide_axis( n );
    }
}

int rf_list_guide_samples( const RfWavefront* wavefront, const RfGuideNotes* notes, int count, RfGuideSample* samples )
{
    int listed = 0;
    for ( int slot = 0; slot < count; ++slot )
    {
        for ( int k = 0; k < notes->count[slot]; ++k )
        {
            const RfNotedVertex* noted = &notes->vertex[slot][k];
            float found = rf_maxf( found_by( wavefront, slot ) - noted->found, 0.0f );
            bool known = noted->throughput > 0.0f && noted->before > 0.0f && noted->sample.pdf_bsdf > 0.0f;
            float light = known ? found / noted->throughput * noted->cosine : 0.0f,
                  brought = known ? found / noted->before : 0.0f;
            samples[listed] = noted->sample;
            samples[listed].light = light;
            samples[listed].brought = brought;
            listed += known && light < MOST_LIGHT && brought < MOST_LIGHT;
        }
    }
    return listed;
}

// ---- Tables

typedef struct Bin
{
    double light; // Σ light / density
    int lit;      // samples with light
} Bin;

// Sums over the nodes of a quadtree, from the root on.
typedef struct Quadtree
{
    Bin level[LEVELS][RF_GUIDE_SIDE][RF_GUIDE_SIDE];
} Quadtree;

typedef struct Learner
{
    const RfGuideSample* samples;
    Quadtree tree;
    RfGuideTable halves[2];
    RfGuide* guide;
} Learner;

static void share_out( const Quadtree* tree, int level, int row, int column, double part, RfGuideTable* table )
{
    int side = RF_GUIDE_SIDE >> level, lit = tree->level[level][row][column].lit;
    if ( level == LEVELS - 1 || lit < FEW )
    {
        for ( int r = row * side; r < ( row + 1 ) * side; ++r )
        {
            for ( int c = column * side; c < ( column + 1 ) * side; ++c )
                table->density[r * RF_GUIDE_SIDE + c] = (float)( part / ( side * side ) );
        }
        return;
    }
    double all = tree->level[level][row][column].light;
    for ( int k = 0; k < 4; ++k )
    {
        int r = 2 * row + k / 2, c = 2 * column + k % 2;
        double quarter = ( lit * tree->level[level + 1][r][c].light / all + 0.25 * EQUAL ) / ( lit + EQUAL );
        share_out( tree, level + 1, r, c, part * quarter, table );
    }
}

// Makes a table of each `step`-th of the samples from the `first` on.
static void make_table( Learner* l, const int32_t* index, int count, int first, int step, RfGuideTable* table )
{
    Quadtree* tree = &l->tree;
    memset( tree, 0, sizeof *tree );
    for ( int k = first; k < count; k += step )
    {
        const RfGuideSample* s = l->samples + index[k];
        Bin* bin = &tree->level[LEVELS - 1][s->bin / RF_GUIDE_SIDE][s->bin % RF_GUIDE_SIDE];
        bin->light += (double)s->light / (double)s->pdf_solid_angle;
        bin->lit += s->light > 0.0f;
    }
    for ( int level = LEVELS - 2; level >= 0; --level )
    {
        for ( int k = 0; k < 1 << 2 * level; ++k )
        {
            int row = k >> level, column = k & ( ( 1 << level ) - 1 );
            Bin* to = &tree->level[level][row][column];
            for ( int q = 0; q < 4; ++q )
            {
                const Bin* from = &tree->level[level + 1][2 * row + q / 2][2 * column + q % 2];
                to->light += from->light;
                to->lit += from->lit;
            }
        }
    }
    share_out( tree, 0, 0, 0, 1.0, table );
    rf_finish_guide_table( table );
}

// The share that explains best what was found.
static float choose_share( const Learner* l, const int32_t* index, int count )
{
    double entropy[SHARES] = { 0.0 };
    for ( int k = 0; k < count; ++k )
    {
        const RfGuideSample* s = l->samples + index[k];
        double guided = (double)( l->halves[1 - k % 2].density[s->bin] * s->per_solid_angle ) / (double)s->pdf_bsdf;
        for ( int a = 1; a < SHARES && s->brought > 0.0f; ++a )
            entropy[a] -= (double)s->brought * log( 1.0 + (double)s_shares[a] * ( guided - 1.0 ) );
    }
    int best = 0;
    for ( int a = 1; a < SHARES; ++a )
        best = entropy[a] < entropy[best] ? a : best;
    return s_shares[best];
}

// Returns the number of the leaf's table, or RF_NOT_GUIDED.
static int32_t learn_leaf( Learner* l, const int32_t* index, int count )
{
    int lit = 0;
    for ( int k = 0; k < count; ++k )
        lit += l->samples[index[k]].light > 0.0f;
    if ( lit < LEAST_LIT )
        return RF_NOT_GUIDED;
    for ( int half = 0; half < 2; ++half )
        make_table( l, index, count, half, 2, l->halves + half );
    float share = choose_share( l, index, count );
    if ( !( share > 0.0f ) )
        return RF_NOT_GUIDED;
    RfGuideTable* table = l->guide->tables + l->guide->table_count;
    make_table( l, index, count, 0, 1, table );
    table->share = share;
    return l->guide->table_count++;
}

// ---- The trees

// Sorts `index` so far that its k-th is where it belongs by coordinate, with those before it not above (Hoare's selection). Returns
// that coordinate.
static float select_coordinate( const RfGuideSample* s, int32_t* index, int count, int axis, int k )
{
    int low = 0, high = count - 1;
    while ( low < high )
    {
        float pivot = s[index[( low + high ) / 2]].p[axis];
        int i = low, j = high;
        while ( i <= j )
        {
            while ( s[index[i]].p[axis] < pivot )
                ++i;
            while ( s[index[j]].p[axis] > pivot )
                --j;
            if ( i <= j )
            {
                int32_t swap = index[i];
                index[i++] = index[j];
                index[j--] = swap;
            }
        }
        if ( k > j && k < i )
            break;
        if ( k <= j )
            high = j;
        else
            low = i;
    }
    return s[index[k]].p[axis];
}

static void find_variances( const RfGuideSample* s, const int32_t* index, int count, double variance[3] )
{
    for ( int c = 0; c < 3; ++c )
    {
        double sum = 0.0, squares = 0.0;
        for ( int k = 0; k < count; ++k )
        {
            double x = (double)s[index[k]].p[c] - (double)s[index[0]].p[c];
            sum += x;
            squares += x * x;
        }
        variance[c] = squares - sum * sum / count;
    }
}

// Splits the samples at the median of the coordinate that varies most and splits them well: many are on one wall. Returns how many
// are below; 0: none does.
static int split( const RfGuideSample* s, int32_t* index, int count, RfGuideNode* node )
{
    double variance[3];
    if ( count < 2 * LEAF )
        return 0;
    find_variances( s, index, count, variance );
    for ( int attempt = 0; attempt < 3; ++attempt )
    {
        int axis = variance[0] >= variance[1] && variance[0] >= variance[2] ? 0 : variance[1] >= variance[2] ? 1 : 2;
        float at = select_coordinate( s, index, count, axis, count / 2 );
        int below = 0;
        for ( int k = 0; k < count; ++k )
        {
            if ( !( s[index[k]].p[axis] < at ) )
                continue;
            int32_t swap = index[k];
            index[k] = index[below];
            index[below++] = swap;
        }
        *node = ( RfGuideNode ){ .split = at, .axis = axis, .table = RF_NOT_GUIDED };
        if ( (float)below >= LEAST_PART * (float)count )
            return below;
        variance[axis] = -1.0;
    }
    return 0;
}

static void grow( Learner* l, int node, int depth, int32_t* index, int count )
{
    RfGuideNode here;
    int below = split( l->samples, index, count, &here );
    if ( below == 0 )
    {
        l->guide->nodes[node] = ( RfGuideNode ){ .split = INFINITY, .child = node, .table = learn_leaf( l, index, count ) };
        l->guide->depth = depth > l->guide->depth ? depth : l->guide->depth;
        return;
    }
    here.child = l->guide->node_count;
    l->guide->node_count += 2;
    l->guide->nodes[node] = here;
    grow( l, here.child, depth + 1, index, below );
    grow( l, here.child + 1, depth + 1, index + below, count - below );
}

// What is split has 2 LEAF samples or more, so each half LEAF / 4 or more.
static size_t most_leaves( int count ) { return RF_GUIDE_AXES + (size_t)( count / ( LEAF / 4 ) ); }

// Gives back what is not used.
static void trim( RfGuide* guide )
{
    RfGuideNode* nodes = realloc( guide->nodes, (size_t)guide->node_count * sizeof *nodes );
    RfGuideTable* tables = realloc( guide->tables, ( (size_t)guide->table_count + 1 ) * sizeof *tables );
    guide->nodes = nodes != NULL ? nodes : guide->nodes;
    guide->tables = tables != NULL ? tables : guide->tables;
}

static void learn( Learner* l, int count, int32_t* index )
{
    l->guide->node_count = RF_GUIDE_AXES;
    for ( int axis = 0; axis < RF_GUIDE_AXES; ++axis )
    {
        int of_axis = 0;
        for ( int k = 0; k < count; ++k )
        {
            if ( l->samples[k].axis == axis )
                index[of_axis++] = k;
        }
        grow( l, axis, 0, index, of_axis );
    }
    trim( l->guide );
}

RfGuide* rf_learn_guide( const RfGuideSample* samples, int count )
{
    Learner* l = malloc( sizeof *l );
    int32_t* index = malloc( ( (size_t)count + 1 ) * sizeof *index );
    RfGuide* guide = calloc( 1, sizeof *guide );
    if ( guide != NULL )
    {
        guide->nodes = malloc( 2 * most_leaves( count ) * sizeof *guide->nodes );
        guide->tables = malloc( most_leaves( count ) * sizeof *guide->tables );
    }
    bool fits = l != NULL && index != NULL && guide != NULL && guide->nodes != NULL && guide->tables != NULL;
    if ( fits )
    {
        l->samples = samples;
        l->guide = guide;
        learn( l, count, index );
    }
    free( l );
    free( index );
    if ( !fits )
        rf_destroy_guide( guide );
    return fits ? guide : NULL;
}
