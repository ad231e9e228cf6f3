#include "reuse/harvest/serialise.h"

#include <string.h>

// One traversal of the data serves three purposes: counting bytes, writing and reading.
typedef struct Stream
{
    uint8_t* out;      // written to, unless NULL
    const uint8_t* in; // read from, unless NULL
    size_t used;
} Stream;

static void pass( Stream* s, void* data, size_t bytes )
{
    if ( s->out != NULL && bytes > 0 )
        memcpy( s->out + s->used, data, bytes );
    if ( s->in != NULL && bytes > 0 )
        memcpy( data, s->in + s->used, bytes );
    s->used += bytes;
}

static void pass_lanes( Stream* s, int count, float* lanes ) { pass( s, lanes, (size_t)count * sizeof *lanes ); }

static void pass_lanes3( Stream* s, int count, float* const lanes[3] )
{
    for ( int c = 0; c < 3; ++c )
        pass_lanes( s, count, lanes[c] );
}

// The distinct normals of a batch: a patch sees few triangles.
typedef struct Normals
{
    uint16_t count;
    uint16_t of[RF_LANES]; // by hit: index in list
    float list[RF_LANES][3];
} Normals;

#define SLOTS 4096 // of a hash table, a power of two

static void list_normals( int count, float* const ng[3], Normals* normals )
{
    int16_t slots[SLOTS];
    memset( slots, -1, sizeof slots );
    normals->count = 0;
    for ( int i = 0; i < count; ++i )
    {
        float normal[3] = { ng[0][i], ng[1][i], ng[2][i] };
        uint32_t bits[3];
        memcpy( bits, normal, sizeof bits );
        uint32_t slot = ( ( bits[0] * 0x9e3779b1u ^ bits[1] ) * 0x85ebca6bu ^ bits[2] ) * 0xc2b2ae35u >> 20;
        // bits, as they were hashed: NOLINTNEXTLINE(bugprone-suspicious-memory-comparison)
        while ( slots[slot] >= 0 && memcmp( normals->list[slots[slot]], normal, sizeof normal ) != 0 )
            slot = ( slot + 1 ) % SLOTS;
        if ( slots[slot] < 0 )
        {
            slots[slot] = (int16_t)normals->count;
            memcpy( normals->list[normals->count++], normal, sizeof normal );
        }
        normals->of[i] = (uint16_t)slots[slot];
    }
}

static void pass_normals( Stream* s, int count, float* const ng[3] )
{
    Normals normals;
    if ( s->in == NULL )
        list_normals( count, ng, &normals );
    pass( s, &normals.count, sizeof normals.count );
    pass( s, normals.list, normals.count * sizeof normals.list[0] );
    size_t bytes = normals.count <= 256 ? 1 : 2;
    for ( int i = 0; i < count; ++i )
    {
        uint16_t of = s->in == NULL ? normals.of[i] : 0;
        pass( s, &of, bytes ); // the low byte comes first
        for ( int c = 0; c < 3 && s->in != NULL; ++c )
            ng[c][i] = normals.list[of][c];
    }
}

// r g b and a constant, which is not stored
static void pass_colours( Stream* s, int count, float fourth, float* colours )
{
    for ( int i = 0; i < count; ++i, colours += 4 )
    {
        pass( s, colours, 3 * sizeof *colours );
        if ( s->in != NULL )
            colours[3] = fourth;
    }
}

static void pass_seen( Stream* s, int eyes, int count, uint32_t* seen )
{
    for ( int first = 0; first < eyes; first += 32, seen += RF_LANES )
    {
        size_t bytes = (size_t)( eyes - first < 32 ? ( eyes - first + 7 ) / 8 : 4 );
        for ( int i = 0; i < count; ++i )
        {
            uint32_t word = s->in == NULL ? seen[i] : 0;
            pass( s, &word, bytes );
            if ( s->in != NULL )
                seen[i] = word;
        }
    }
}

// Pixels of a patch are close to each other: stored as offsets from the smallest.
static void pass_pixels( Stream* s, int count, int32_t* pixel )
{
    int32_t least = INT32_MAX, most = 0;
    for ( int i = 0; i < count && s->in == NULL; ++i )
    {
        least = pixel[i] < least ? pixel[i] : least;
        most = pixel[i] > most ? pixel[i] : most;
    }
    uint8_t bytes = most - least < 65536 ? 2 : 4;
    pass( s, &least, sizeof least );
    pass( s, &bytes, sizeof bytes );
    for ( int i = 0; i < count; ++i )
    {
        uint32_t beyond = s->in == NULL ? (uint32_t)( pixel[i] - least ) : 0;
        pass( s, &beyond, bytes );
        if ( s->in != NULL )
            pixel[i] = least + (int32_t)beyond;
    }
}

static void pass_directions( Stream* s, const RfBatchShape* shape, int count, const RfDirectionLanes* directions )
{
    for ( int d = 0; d < rf_direction_count( shape ); ++d )
    {
        pass_lanes3( s, count, directions[d].wi );
        pass_lanes3( s, count, directions[d].q );
        if ( !shape->eq15 )
            continue;
        pass_lanes3( s, count, directions[d].a );
        pass_lanes3( s, count, directions[d].b );
        pass_lanes( s, count, directions[d].light_pdf );
    }
}

static void pass_glossy( Stream* s, const RfBatchShape* shape, RfHitBatch* batch )
{
    int count = batch->count - batch->first[RF_BSDF_FIRST_GLOSSY];
    pass_lanes3( s, count, batch->n );
    pass_lanes3( s, count, batch->wo );
    for ( int p = 0; p < RF_PARAM_COUNT; ++p )
    {
        if ( rf_has_param( shape->params, (RfBsdfParam)p ) )
            pass_lanes( s, count, batch->param[p] );
    }
    pass_directions( s, shape, count, batch->directions );
}

static void pass_batch( Stream* s, const RfBatchShape* shape, RfHitBatch* batch )
{
    pass( s, &batch->eye, sizeof batch->eye );
    if ( rf_is_blurred_shape( shape ) )
        pass( s, &batch->lens, sizeof batch->lens );
    pass( s, &batch->count, sizeof batch->count );
    pass( s, &batch->miss_count, sizeof batch->miss_count );
    pass( s, &batch->sky_count, sizeof batch->sky_count );
    pass( s, &batch->glint_count, sizeof batch->glint_count );
    pass( s, batch->first, sizeof batch->first );
    pass( s, &batch->has_views, sizeof batch->has_views );
    int count = batch->count;
    pass_lanes3( s, count, batch->p );
    pass_normals( s, count, batch->ng );
    pass_lanes( s, count, batch->density_sum );
    pass_colours( s, count + ( shape->own_frame_light ? batch->miss_count : 0 ), 1.0f, batch->radiance );
    pass_colours( s, batch->glint_count, 0.0f, rf_glint_radiance( batch ) );
    pass_seen( s, shape->eyes, count, batch->seen );
    for ( int l = 0; l < shape->eyes && rf_is_partial( shape ); ++l )
        pass_lanes( s, count, batch->densities + (size_t)l * RF_LANES );
    for ( int l = 0; l < shape->eyes && shape->panes && shape->chains; ++l )
        pass_lanes3( s, count,
                     ( float* [3] ){ batch->panes[0] + (size_t)l * RF_LANES, batch->panes[1] + (size_t)l * RF_LANES,
                                     batch->panes[2] + (size_t)l * RF_LANES } );
    pass_pixels( s, count + batch->miss_count + batch->glint_count, batch->pixel );
    for ( int c = 0; c < 2 && shape->filtered; ++c )
        pass_lanes( s, count + batch->miss_count + batch->glint_count, batch->offset[c] );
    if ( shape->chains )
        pass( s, batch->view, (size_t)count );
    pass( s, batch->rows, (size_t)shape->eyes * 2 * sizeof *batch->rows );
    if ( shape->params != 0 )
        pass_glossy( s, shape, batch );
}

size_t rf_serialise_batch( const RfBatchShape* shape, const RfHitBatch* batch, void* memory )
{
    Stream stream = { .out = memory };
    RfHitBatch copy = *batch; // its arrays are only read
    pass_batch( &stream, shape, &copy );
    return stream.used;
}

void rf_deserialise_batch( const RfBatchShape* shape, const void* memory, RfHitBatch* batch )
{
    Stream stream = { .in = memory };
    pass_batch( &stream, shape, batch );
}
