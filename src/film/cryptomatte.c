// Cryptomatte's ids, ranks and manifest.
#include "film/cryptomatte.h"

#include "base/words.h"
#include "scene/placement.h"
#include "trace/trace.h"

#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define KIND( word, name )                                                                                                       \
    {                                                                                                                            \
        word, name, { name "00", name "01", name "02" }                                                                          \
    }
const RfCryptomatteKind g_rf_cryptomatte_kinds[RF_CRYPTOMATTE_KINDS] = {
    KIND( "object", "CryptoObject" ),
    KIND( "material", "CryptoMaterial" ),
    KIND( "asset", "CryptoAsset" ),
};

static uint32_t rotate( uint32_t x, int bits ) { return x << bits | x >> ( 32 - bits ); }

static uint32_t scramble( uint32_t block ) { return rotate( block * 0xcc9e2d51u, 15 ) * 0x1b873593u; }

uint32_t rf_murmur3_32( const char* text )
{
    size_t length = strlen( text ), whole = length / 4 * 4;
    const unsigned char* bytes = (const unsigned char*)text;
    uint32_t hash = 0, tail = 0;
    for ( size_t i = 0; i < whole; i += 4 )
    {
        uint32_t block = bytes[i] | (uint32_t)bytes[i + 1] << 8 | (uint32_t)bytes[i + 2] << 16 | (uint32_t)bytes[i + 3] << 24;
        hash = rotate( hash ^ scramble( block ), 13 ) * 5 + 0xe6546b64u;
    }
    for ( size_t i = length; i > whole; --i )
        tail = tail << 8 | bytes[i - 1];
    hash ^= scramble( tail ); // 0 without a tail
    hash ^= (uint32_t)length;
    hash = ( hash ^ hash >> 16 ) * 0x85ebca6bu;
    hash = ( hash ^ hash >> 13 ) * 0xc2b2ae35u;
    return hash ^ hash >> 16;
}

uint32_t rf_cryptomatte_id( const char* name )
{
    uint32_t hash = rf_murmur3_32( name ), exponent = hash >> 23 & 255u;
    exponent = exponent < 1 ? 1 : exponent > 254 ? 254 : exponent;
    return ( hash & 0x807fffffu ) | exponent << 23;
}

// The set of RF_CRYPTOMATTE bits and its text.

RfResult rf_parse_cryptomatte( const char* text, unsigned* kinds, RfError* error )
{
    const char* words[RF_CRYPTOMATTE_KINDS];
    unsigned bits[RF_CRYPTOMATTE_KINDS];
    for ( int k = 0; k < RF_CRYPTOMATTE_KINDS; ++k )
    {
        words[k] = g_rf_cryptomatte_kinds[k].word;
        bits[k] = 1u << k;
    }
    RfWordSet set = { "Cryptomatte", "Cryptomatte of kind", "object, material or asset", words, bits, RF_CRYPTOMATTE_KINDS };
    return rf_parse_words( &set, text, kinds, error );
}

void rf_format_cryptomatte( unsigned kinds, char text[RF_CRYPTOMATTE_TEXT_SIZE] )
{
    text[0] = '\0';
    for ( int k = 0; k < RF_CRYPTOMATTE_KINDS; ++k )
    {
        if ( ( kinds & 1u << k ) != 0 )
            rf_append( text, RF_CRYPTOMATTE_TEXT_SIZE, "%s%s", text[0] != '\0' ? "," : "", g_rf_cryptomatte_kinds[k].word );
    }
}

// The name of object `i` (from node −1 on) or material `i`.
static const char* name_of( const RfScene* scene, unsigned kind, int i )
{
    if ( 1u << kind == RF_CRYPTOMATTE_MATERIAL )
        return scene->materials[i].name != NULL ? scene->materials[i].name : "unnamed";
    return 1u << kind == RF_CRYPTOMATTE_OBJECT ? rf_object_name( scene, i - 1 ) : rf_asset_name( scene, i - 1 );
}

static int names_of( const RfScene* scene, int kind )
{
    return 1u << kind == RF_CRYPTOMATTE_MATERIAL ? (int)scene->material_count : scene->node_count + 1;
}

RfResult rf_make_cryptomatte_ids( const RfScene* scene, int kind, RfCryptomatteIds* ids, RfError* error )
{
    int count = names_of( scene, kind );
    *ids = ( RfCryptomatteIds ){ kind, scene->material_count, malloc( ( (size_t)count + 1 ) * sizeof *ids->id ) };
    if ( ids->id == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for the names of %d objects", count );
    for ( int i = 0; i < count; ++i )
        ids->id[i] = rf_cryptomatte_id( name_of( scene, (unsigned)kind, i ) );
    return RF_OK;
}

void rf_destroy_cryptomatte_ids( RfCryptomatteIds* ids )
{
    free( ids->id );
    ids->id = NULL;
}

typedef struct Rank
{
    uint32_t id;
    double weight;
} Rank;

// Before another: it covers more, or its id is less.
static bool goes_before( Rank a, Rank b ) { return a.weight > b.weight || ( a.weight == b.weight && a.id < b.id ); }

// Surfaces of a pixel by id, in order; returns how many.
static int list_ranks( const RfCovering* pixel, const RfCryptomatteIds* ids, Rank ranks[RF_COVERING_MOST] )
{
    bool materials = 1u << ids->kind == RF_CRYPTOMATTE_MATERIAL;
    int count = 0;
    for ( int k = 0; k < RF_COVERING_MOST && pixel->surface[k] != 0; ++k )
    {
        uint32_t pair = pixel->surface[k] - 1;
        uint32_t id = ids->id[materials ? pair % ids->material_count : pair / ids->material_count];
        int at = 0;
        while ( at < count && ranks[at].id != id )
            ++at;
        ranks[at] = ( Rank ){ id, ( at < count ? ranks[at].weight : 0.0 ) + (double)pixel->weight[k] };
        count += at == count;
    }
    for ( int i = 1; i < count; ++i )
    {
        for ( int k = i; k > 0 && goes_before( ranks[k], ranks[k - 1] ); --k )
        {
            Rank other = ranks[k];
            ranks[k] = ranks[k - 1];
            ranks[k - 1] = other;
        }
    }
    return count;
}

static void finish_pixel( const RfCovering* pixel, const RfCryptomatteIds* ids, size_t i,
                          float* const layers[RF_CRYPTOMATTE_LAYERS] )
{
    Rank ranks[RF_COVERING_MOST];
    int listed = list_ranks( pixel, ids, ranks );
    double all = (double)pixel->nothing + (double)pixel->lost;
    for ( int k = 0; k < listed; ++k )
        all += ranks[k].weight;
    for ( int k = 0; k < 2 * RF_CRYPTOMATTE_LAYERS; ++k )
    {
        float* out = layers[k / 2] + 4 * i + 2 * ( k % 2 );
        out[0] = out[1] = 0.0f;
        if ( k >= listed )
            continue;
        memcpy( out, &ranks[k].id, sizeof *out );
        out[1] = (float)( ranks[k].weight / all );
    }
}

void rf_finish_cryptomatte( const RfCovering* pixels, size_t count, const RfCryptomatteIds* ids,
                            float* const layers[RF_CRYPTOMATTE_LAYERS] )
{
#pragma omp parallel
    {
        rf_set_float_mode();
#pragma omp for schedule( static )
        for ( size_t i = 0; i < count; ++i )
            finish_pixel( pixels + i, ids, i, layers );
    }
}

// The manifest.

// The names of a kind that surfaces have, some more than once; NULL: there is no memory.
static const char** list_names( const RfScene* scene, int kind, int* listed )
{
    int count = names_of( scene, kind );
    bool materials = 1u << kind == RF_CRYPTOMATTE_MATERIAL;
    const char** names = malloc( ( (size_t)count + 1 ) * sizeof *names );
    bool* marked = malloc( ( (size_t)scene->node_count + 1 ) * sizeof *marked );
    *listed = 0;
    if ( names == NULL || marked == NULL )
    {
        free( names );
        free( marked );
        return NULL;
    }
    if ( !materials )
        rf_mark_objects( scene, marked );
    for ( int i = 0; i < count; ++i )
    {
        if ( materials || marked[i] )
            names[( *listed )++] = name_of( scene, (unsigned)kind, i );
    }
    free( marked );
    return names;
}

char* rf_cryptomatte_manifest( const RfScene* scene, int kind )
{
    int listed;
    const char** names = list_names( scene, kind, &listed );
    json_t* ids = names != NULL ? json_object() : NULL;
    for ( int i = 0; i < listed; ++i )
        json_object_set_new( ids, names[i], json_sprintf( "%08x", rf_cryptomatte_id( names[i] ) ) );
    char* text = ids != NULL ? json_dumps( ids, JSON_COMPACT | JSON_SORT_KEYS ) : NULL;
    json_decref( ids );
    free( names );
    return text;
}

// A name with its id, in the kinds that have it.
typedef struct Named
{
    uint32_t id;
    unsigned kinds;
    const char* name;
} Named;

static int compare_named( const void* a, const void* b )
{
    const Named *first = a, *second = b;
    return first->id != second->id ? ( first->id > second->id ) - ( first->id < second->id )
                                   : strcmp( first->name, second->name );
}

void rf_warn_of_equal_ids( const RfScene* scene, unsigned kinds, RfLog* log )
{
    size_t count = 0, kept = 0;
    Named* all = NULL;
    for ( int k = 0; k < RF_CRYPTOMATTE_KINDS; ++k )
    {
        int listed = 0;
        const char** names = ( kinds & 1u << k ) != 0 ? list_names( scene, k, &listed ) : NULL;
        Named* grown = realloc( all, ( count + (size_t)listed + 1 ) * sizeof *all );
        all = grown != NULL ? grown : all;
        for ( int i = 0; i < listed && grown != NULL; ++i )
            all[count++] = ( Named ){ rf_cryptomatte_id( names[i] ), 1u << k, names[i] };
        free( names );
    }
    if ( count > 0 )
        qsort( all, count, sizeof *all, compare_named );
    for ( size_t i = 0; i < count; ++i )
    {
        bool known = kept > 0 && compare_named( all + kept - 1, all + i ) == 0;
        if ( known )
            all[kept - 1].kinds |= all[i].kinds;
        else
            all[kept++] = all[i];
    }
    for ( size_t i = 1; i < kept; ++i )
    {
        if ( all[i].id == all[i - 1].id && ( all[i].kinds & all[i - 1].kinds ) != 0 )
            rf_warn( log, "%s: '%.200s' and '%.200s' have one Cryptomatte id, %08x, and so one matte: rename one of them",
                     scene->path, all[i - 1].name, all[i].name, all[i].id );
    }
    free( all );
}
