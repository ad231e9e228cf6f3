// Copies of vertex lanes, and the random numbers of lanes.
#include "path/lanes.h"

#include "path/wavefront.h"

#include <string.h>

#define LANE_BYTES 4 // of every array

// A single lane is copied without a call.
static inline void copy( const void* from, int count, void* to )
{
    if ( count == 1 )
        memcpy( to, from, LANE_BYTES );
    else
        memcpy( to, from, (size_t)count * LANE_BYTES );
}

#define COPY( array )                                                                                                            \
    do                                                                                                                           \
    {                                                                                                                            \
        _Static_assert( sizeof to->array[0] == LANE_BYTES, "lanes of another size" );                                            \
        copy( from->array + first, count, to->array + at );                                                                      \
    } while ( 0 )
#define COPY3( array )                                                                                                           \
    for ( int c = 0; c < 3; ++c )                                                                                                \
    COPY( array[c] )

void rf_copy_vertices( const RfVertexLanes* from, int first, int count, RfBsdfParams params, RfVertexLanes* to, int at )
{
    COPY3( p );
    COPY3( ng );
    COPY3( n );
    COPY3( wo );
    COPY( offset );
    for ( RfBsdfParams left = params; left != 0; left &= left - 1 )
    {
        RfBsdfParam p = rf_first_param( left );
        COPY( param[p] );
    }
    COPY3( absorption );
    COPY3( emission );
    COPY( light_pdf_solid_angle );
    COPY( material );
    COPY( ray );
    COPY( slot );
    to->guide = from->guide;
    if ( from->guide != NULL )
        COPY( table );
}

// The coordinate of a lattice that a dimension has, or −1: its numbers are random.
static int coordinate_of( const RfLattice* lattice, uint32_t dimension )
{
    static const int s_scatter[] = { RF_LATTICE_DIRECTION, RF_LATTICE_DIRECTION + 1, RF_LATTICE_CHOICE, -1 };
    static const int s_light[] = { RF_LATTICE_CHOICE, RF_LATTICE_DIRECTION, RF_LATTICE_DIRECTION + 1 };
    if ( lattice->vertex == 0 )
        return -1;
    switch ( dimension )
    {
        case RF_DIMENSION_FILM_X: return RF_LATTICE_FILM;
        case RF_DIMENSION_FILM_Y: return RF_LATTICE_FILM + 1;
        case RF_DIMENSION_CHAINS: return RF_LATTICE_COAT;
        case RF_DIMENSION_CHAINS + RF_DIMENSION_FIRST_VERTEX + RF_DIMENSION_SCATTER + 2: return RF_LATTICE_CHAIN;
        case RF_DIMENSION_SIDES + 1: return RF_LATTICE_SIDE;
        default: break;
    }
    uint32_t place = dimension - RF_DIMENSION_FIRST_VERTEX;
    if ( place >= lattice->vertex )
        return -1;
    return place < RF_DIMENSION_LIGHTS ? s_scatter[place] : s_light[( place - RF_DIMENSION_LIGHTS ) % 3];
}

static void draw_words( const RfWavefront* keys, int count, const int32_t* slot, uint32_t dimension, uint32_t* restrict out )
{
    const RfLattice* lattice = &keys->lattice;
    int coordinate = coordinate_of( lattice, dimension );
    if ( coordinate < 0 )
    {
#pragma omp simd
        for ( int i = 0; i < count; ++i )
        {
            RfRandomKey key = { keys->key_a[slot[i]], keys->key_b[slot[i]] };
            out[i] = rf_random_bits( key, dimension );
        }
        return;
    }
    RfLatticeSteps step = rf_lattice_steps[coordinate];
    uint32_t step_here = step.pass * lattice->pass + step.frame * lattice->frame;
#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        RfRandomKey block = { lattice->key_a[slot[i]], lattice->key_b[slot[i]] };
        out[i] = rf_random_bits( block, dimension ) + step_here + step.x * lattice->x[slot[i]] + step.y * lattice->y[slot[i]];
    }
}

void rf_draw_lanes( const RfWavefront* keys, int count, const int32_t* slot, uint32_t dimension, int numbers,
                    float random[][RF_LANES] )
{
    uint32_t word[RF_LANES];
    for ( int k = 0; k < numbers; ++k )
    {
        draw_words( keys, count, slot, dimension + (uint32_t)k, word );
        float* restrict out = random[k];
#pragma omp simd
        for ( int i = 0; i < count; ++i )
            out[i] = rf_fraction( word[i] );
    }
}

// Two words to select a light: of the dimension and of its twin.
static void draw_bits( const RfWavefront* keys, int count, const int32_t* slot, uint32_t dimension, uint32_t bits[2][RF_LANES] )
{
    draw_words( keys, count, slot, dimension, bits[0] );
    draw_words( keys, count, slot, dimension | RF_DIMENSION_TWIN, bits[1] );
}

void rf_draw_light_numbers( const RfWavefront* keys, int count, const int32_t* slot, uint32_t dimension, RfLaneScratch* scratch )
{
    uint32_t own = dimension & ~RF_DIMENSION_OPPOSITE;
    draw_bits( keys, count, slot, own, scratch->bits );
    rf_draw_lanes( keys, count, slot, own + 1, 2, scratch->random );
    if ( own == dimension )
        return;
    float *u = scratch->random[0], *v = scratch->random[1];
    for ( int i = 0; i < count; ++i )
    {
        scratch->bits[0][i] ^= 0x80000000u;
        u[i] += u[i] < 0.5f ? 0.5f : -0.5f;
        v[i] += v[i] < 0.5f ? 0.5f : -0.5f;
    }
}
