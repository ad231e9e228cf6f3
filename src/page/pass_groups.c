// Groups the channels of a file into passes, and reads the manifests of Cryptomattes.
#include "page/pass_groups.h"

#include "film/aov.h"
#include "output/names.h"

#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct Manifests
{
    json_t* names; // { KEY: the Cryptomatte's name }
    json_t* ids;   // { KEY: { name: "3f2a91c4" } }
} Manifests;

static void take_string( void* user, const char* name, const char* value )
{
    static const char begin[] = "cryptomatte/";
    const Manifests* to = user;
    const char* key = name + sizeof begin - 1;
    if ( strncmp( name, begin, sizeof begin - 1 ) != 0 )
        return;
    const char* slash = strchr( key, '/' );
    if ( slash == NULL || slash - key > 31 )
        return;
    char text[32];
    snprintf( text, sizeof text, "%.*s", (int)( slash - key ), key );
    if ( strcmp( slash, "/name" ) == 0 )
        json_object_set_new( to->names, text, json_string( value ) );
    else if ( strcmp( slash, "/manifest" ) == 0 )
        json_object_set_new( to->ids, text, json_loads( value, 0, NULL ) );
}

static int compare_ids( const void* first, const void* second )
{
    const RfMatteName *a = first, *b = second;
    return ( a->id > b->id ) - ( a->id < b->id );
}

static bool take_names( json_t* ids, RfMatteNames* list )
{
    const char* name;
    json_t* id;
    list->names = malloc( ( json_object_size( ids ) + 1 ) * sizeof *list->names );
    if ( list->names == NULL )
        return false;
    json_object_foreach( ids, name, id )
    {
        const char* text = json_string_value( id );
        RfMatteName* row = list->names + list->count;
        if ( text == NULL )
            continue;
        *row = ( RfMatteName ){ .id = (uint32_t)strtoul( text, NULL, 16 ), .name = strdup( name ) };
        if ( row->name == NULL )
            return false;
        list->count += 1;
    }
    qsort( list->names, (size_t)list->count, sizeof *list->names, compare_ids );
    return true;
}

RfResult rf_read_matte_names( const char* path, const RfFilePass* pass, RfMatteNames* names, RfError* error )
{
    *names = ( RfMatteNames ){ 0 };
    Manifests manifests = { json_object(), json_object() };
    RfResult result = rf_list_exr_strings( path, take_string, &manifests, error );
    const char* key;
    json_t* crypto;
    json_object_foreach( manifests.names, key, crypto )
    {
        const char *name = json_string_value( crypto ), *last = name != NULL ? strrchr( name, '.' ) : NULL;
        json_t* ids = json_object_get( manifests.ids, key );
        if ( result != RF_OK || name == NULL || strcmp( last != NULL ? last + 1 : name, pass->name ) != 0 || ids == NULL ||
             names->names != NULL )
            continue;
        if ( !take_names( ids, names ) )
            result = rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory for the names of its Cryptomatte", path );
    }
    json_decref( manifests.names );
    json_decref( manifests.ids );
    return result;
}

void rf_free_matte_names( RfMatteNames* names )
{
    for ( int i = 0; i < names->count; ++i )
        free( names->names[i].name );
    free( names->names );
    *names = ( RfMatteNames ){ 0 };
}

int rf_find_matte_name( const RfMatteNames* names, uint32_t id )
{
    const RfMatteName key = { .id = id }, *found = NULL;
    if ( names->count > 0 )
        found = bsearch( &key, names->names, (size_t)names->count, sizeof key, compare_ids );
    return found != NULL ? (int)( found - names->names ) : -1;
}

// How an AOV looks; false: it is none. Without a default, so that the compiler names a new one.
static bool look_of( RfAov aov, RfLook* look )
{
    switch ( aov )
    {
        case RF_AOV_PRIMAL:
        case RF_AOV_REMOVED:
        case RF_AOV_HALF:
        case RF_AOV_DENOISE_ALBEDO:
        RF_PASS_AOV_CASES:
        case RF_AOV_ALBEDO: *look = RF_LOOK_LIGHT; return true;
        case RF_AOV_DENOISE_NORMAL:
        case RF_AOV_NORMAL: *look = RF_LOOK_NORMAL; return true;
        case RF_AOV_DEPTH: *look = RF_LOOK_DEPTH; return true;
        case RF_AOV_MOTION: *look = RF_LOOK_MOTION; return true;
        case RF_AOV_VARIANCE: *look = RF_LOOK_DEVIATION; return true;
        case RF_AOV_SAMPLES:
        case RF_AOV_ALPHA: *look = RF_LOOK_SHARE; return true;
        case RF_AOV_DX:
        case RF_AOV_DY: *look = RF_LOOK_SIGNED; return true;
        case RF_AOV_OBJECT_INDEX:
        case RF_AOV_MATERIAL_INDEX: *look = RF_LOOK_INDEX; return true;
        case RF_AOV_COUNT: break;
    }
    return false;
}

// Reflectances: no light, but as bright.
static bool is_albedo( const char* name )
{
    static const char word[] = "albedo";
    size_t length = strlen( name ), end = sizeof word - 1;
    return length >= end && strcmp( name + length - end, word ) == 0;
}

#define BLENDER_GROUP "Combined_"
#define NUKE_MOTION "backward" // of the previous frame; the next is "forward"
#define CRYPTO "Crypto"

// A channel, and where it belongs.
typedef struct Place
{
    const RfExrName* channel;
    char name[RF_PASS_NAME_SIZE];  // of the pass
    char layer[RF_PASS_NAME_SIZE]; // of the file that it is in; "": the pass may have several
    int order;                     // of the pass: its AOV, or behind them
    int rank, letter;              // of a Cryptomatte's layer; of the channel in its layer
    bool is_bare;                  // without a layer in its part
    bool negated;
} Place;

// The place of a letter in its layer, or -1.
static int letter_place( const char* letter )
{
    static const char* const s_letters[] = { "RrXxUu", "GgYyVv", "BbZz", "AaWw" };
    static const char* const s_words[] = { "red", "green", "blue", "alpha" };
    for ( int i = 0; i < 4; ++i )
    {
        if ( ( letter[0] != '\0' && letter[1] == '\0' && strchr( s_letters[i], letter[0] ) != NULL ) ||
             strcmp( letter, s_words[i] ) == 0 )
            return i;
    }
    return -1;
}

// The rank of "CryptoObject01", 1, which is cut off; -1: it is none.
static int cut_rank( char* name )
{
    size_t length = strlen( name ), end = length;
    while ( end > 0 && name[end - 1] >= '0' && name[end - 1] <= '9' )
        --end;
    if ( strncmp( name, CRYPTO, strlen( CRYPTO ) ) != 0 || end == length || length - end > 3 )
        return -1;
    int rank = atoi( name + end );
    name[end] = '\0';
    return rank;
}

// Is it of an AOV, by any of the namings?
static bool is_of_aov( const RfExrName* channel, Place* place )
{
    for ( RfAov aov = 0; aov < RF_AOV_ALPHA; ++aov )
    {
        const char* letters = rf_aov_letters( aov );
        for ( int i = 0; letters[i] != '\0'; ++i )
        {
            if ( !rf_is_pass_channel( channel->text, rf_aov_name( aov ), letters[i], &place->negated ) )
                continue;
            snprintf( place->name, sizeof place->name, "%s", rf_aov_name( aov ) );
            place->order = (int)aov;
            place->letter = i;
            return true;
        }
    }
    place->negated = false;
    return false;
}

// The layer of a channel in its file, without its letter where that is one: "ViewLayer.Depth". "": it is the picture's.
static void find_layer( const RfExrHeader* header, const RfExrName* channel, bool has_letter, char* layer )
{
    const char *own = channel->own, *dot = strrchr( own, '.' );
    int room = RF_PASS_NAME_SIZE - 1, length = dot != NULL ? (int)( dot - own ) : 0;
    if ( !has_letter ) // a pass of a single channel
        snprintf( layer, RF_PASS_NAME_SIZE, "%.*s", room, own );
    else if ( dot == NULL && channel->part != header->part && own > channel->text ) // the part is the layer
        snprintf( layer, RF_PASS_NAME_SIZE, "%.*s", (int)( own - channel->text ) - 1, channel->text );
    else
        snprintf( layer, RF_PASS_NAME_SIZE, "%.*s", length < room ? length : room, own );
}

// False: the channel is of the colour.
static bool place_channel( const RfExrHeader* header, const RfExrName* channel, Place* place )
{
    const char* dot = strrchr( channel->own, '.' );
    *place = ( Place ){ .channel = channel, .rank = -1, .order = RF_AOV_COUNT + 1, .is_bare = dot == NULL };
    place->letter = letter_place( dot != NULL ? dot + 1 : channel->own );
    find_layer( header, channel, place->letter >= 0, place->layer );
    const char *last = strrchr( place->layer, '.' ), *word = last != NULL ? last + 1 : place->layer;
    bool is_picture = place->layer[0] == '\0' || strcmp( word, "Combined" ) == 0 || strcmp( word, "rgba" ) == 0;
    if ( is_of_aov( channel, place ) )
    {
        if ( strcmp( word, "forward" ) == 0 ) // Nuke's two layers of motion are one pass
            snprintf( place->layer, sizeof place->layer, NUKE_MOTION );
        return true;
    }
    if ( is_picture && strcmp( channel->own, "Z" ) == 0 )
        place->order = RF_AOV_DEPTH;
    else if ( is_picture && place->letter == 3 )
        place->order = RF_AOV_ALPHA;
    else if ( is_picture )
        return false;
    if ( place->order < RF_AOV_COUNT )
        snprintf( place->name, sizeof place->name, "%s", rf_aov_name( (RfAov)place->order ) );
    else if ( strncmp( word, BLENDER_GROUP, strlen( BLENDER_GROUP ) ) == 0 )
        snprintf( place->name, sizeof place->name, RF_LIGHT_LAYER "%.200s", word + strlen( BLENDER_GROUP ) );
    else
        snprintf( place->name, sizeof place->name, "%s", place->letter >= 0 ? word : place->layer );
    if ( strncmp( place->name, RF_LIGHT_LAYER, strlen( RF_LIGHT_LAYER ) ) == 0 )
        place->order = RF_AOV_COUNT;
    place->rank = cut_rank( place->name );
    return true;
}

static int compare_ints( int a, int b ) { return ( a > b ) - ( a < b ); }

static int compare_places( const void* first, const void* second )
{
    const Place *a = first, *b = second;
    int order = compare_ints( a->order, b->order );
    order = order != 0 ? order : strcmp( a->name, b->name );
    if ( order == 0 && a->rank < 0 && b->rank < 0 )
    {
        order = compare_ints( a->channel->part, b->channel->part );
        order = order != 0 ? order : compare_ints( a->is_bare, b->is_bare );
        order = order != 0 ? order : strcmp( a->layer, b->layer );
    }
    order = order != 0 ? order : compare_ints( a->rank, b->rank );
    order = order != 0 ? order : compare_ints( a->letter, b->letter );
    return order != 0 ? order : strcmp( a->channel->text, b->channel->text );
}

// Of one pass? A Cryptomatte may have a part for each layer, as Nuke's motion.
static bool are_together( const Place* a, const Place* b )
{
    bool is_same = strcmp( a->name, b->name ) == 0 && ( a->rank < 0 ) == ( b->rank < 0 );
    bool is_near = ( a->channel->part == b->channel->part || strcmp( a->layer, NUKE_MOTION ) == 0 ) && a->is_bare == b->is_bare &&
                   strcmp( a->layer, b->layer ) == 0;
    return is_same && ( is_near || a->rank >= 0 );
}

static bool has_letter( const Place* place, char letter )
{
    const char* own = place->channel->own;
    size_t length = strlen( own );
    return length > 0 && ( own[length - 1] == letter || strcmp( own, "red" ) == 0 );
}

static bool is_index( const char* name )
{
    size_t length = strlen( name );
    return ( length > 6 && strcmp( name + length - 6, "_index" ) == 0 ) || strncmp( name, "Index", 5 ) == 0;
}

// False: it is not shown, since channels are missing.
static bool choose_look( const Place* first, RfFilePass* pass )
{
    bool is_colour = pass->channel_count >= 3 && ( has_letter( first, 'R' ) || has_letter( first, 'r' ) );
    pass->is_group = first->order == RF_AOV_COUNT && is_colour;
    if ( first->order < RF_AOV_COUNT )
        look_of( (RfAov)first->order, &pass->look );
    else if ( first->rank >= 0 )
        pass->look = RF_LOOK_MATTES;
    else if ( pass->channel_count == 1 )
        pass->look = is_index( pass->name ) ? RF_LOOK_INDEX : RF_LOOK_SHARE;
    else if ( pass->channel_count == 2 )
        pass->look = RF_LOOK_MOTION;
    else
        pass->look = is_colour ? RF_LOOK_LIGHT : RF_LOOK_SIGNED;
    pass->is_light = pass->look == RF_LOOK_DEVIATION || ( pass->look == RF_LOOK_LIGHT && !is_albedo( pass->name ) );
    if ( pass->look == RF_LOOK_MATTES )
        return pass->channel_count % 2 == 0;
    bool is_whole = pass->channel_count >= rf_look_channels( pass->look );
    pass->channel_count = rf_look_channels( pass->look );
    return is_whole;
}

static void add_pass( const Place* places, int count, RfFilePasses* list, int* used )
{
    RfFilePass* pass = list->passes + list->count;
    *pass = ( RfFilePass ){
        .channels = list->names + *used, .channel_count = count, .all_channels = count, .window = places[0].channel->window
    };
    snprintf( pass->name, sizeof pass->name, "%s", places[0].name );
    snprintf( pass->layer, sizeof pass->layer, "%s", places[0].layer );
    if ( !choose_look( places, pass ) )
        return;
    for ( int i = 0; i < count; ++i )
    {
        pass->channels[i] = places[i].channel->text;
        pass->negated |= places[i].negated ? 1u << i : 0u;
    }
    if ( list->count > 0 && strcmp( pass[-1].name, pass->name ) == 0 ) // twice in the file
    {
        const char* text = places[0].channel->text;
        snprintf( pass->name, sizeof pass->name, "%.*s", (int)strlen( text ) - 2, text );
    }
    *used += count;
    list->count += 1;
}

RfResult rf_list_passes( const RfExrHeader* header, RfFilePasses* passes, RfError* error )
{
    size_t room = (size_t)header->channel_count + 1;
    int count = 0, used = 0;
    Place* places = malloc( room * sizeof *places );
    *passes = ( RfFilePasses ){ .passes = malloc( room * sizeof( RfFilePass ) ), .names = malloc( room * sizeof( char* ) ) };
    if ( places == NULL || passes->passes == NULL || passes->names == NULL )
    {
        free( places );
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for the names of %d channels", header->channel_count );
    }
    for ( int i = 0; i < header->channel_count; ++i )
        count += place_channel( header, header->channels + i, places + count );
    qsort( places, (size_t)count, sizeof *places, compare_places );
    for ( int i = 0, end; i < count; i = end )
    {
        for ( end = i + 1; end < count && are_together( places + i, places + end ); )
            ++end;
        add_pass( places + i, end - i, passes, &used );
    }
    free( places );
    return RF_OK;
}

void rf_free_passes( RfFilePasses* passes )
{
    free( passes->passes );
    free( passes->names );
    *passes = ( RfFilePasses ){ 0 };
}

const RfFilePass* rf_find_pass( const RfFilePasses* passes, const char* name )
{
    for ( int way = 0; way < 3; ++way ) // "depth", "ViewLayer.Depth", "Depth"
    {
        for ( int i = 0; i < passes->count; ++i )
        {
            const RfFilePass* pass = passes->passes + i;
            const char* dot = strchr( pass->layer, '.' );
            if ( strcmp( way == 0 ? pass->name : way == 1 || dot == NULL ? pass->layer : dot + 1, name ) == 0 )
                return pass;
        }
    }
    return NULL;
}

void rf_name_passes( const RfFilePasses* passes, char* text, size_t size )
{
    size_t used = 0;
    text[0] = '\0';
    for ( int i = 0; i < passes->count; ++i )
    {
        const char* name = passes->passes[i].name;
        bool fits = used + strlen( name ) + 2 + 5 < size; // and "..." behind it
        used += (size_t)snprintf( text + used, size - used, "%s%s", used > 0 ? ", " : "", fits ? name : "..." );
        if ( !fits )
            break;
    }
}

static RfResult read_passes( const char* path, const RfFilePass* passes, int count, RfExrWindow* window, float** values,
                             int* stride, size_t* clipped, RfError* error )
{
    const char* names[RF_EXR_MAX_CHANNELS];
    bool negated[RF_EXR_MAX_CHANNELS];
    *stride = 0;
    for ( int i = 0; i < count; ++i )
    {
        for ( int c = 0; c < passes[i].channel_count && *stride < RF_EXR_MAX_CHANNELS; ++c, ++*stride )
        {
            names[*stride] = passes[i].channels[c];
            negated[*stride] = ( passes[i].negated >> c & 1u ) != 0;
        }
    }
    RfResult result = rf_read_exr_values( path, names, *stride, window, values, clipped, error );
    size_t pixels = (size_t)window->width * (size_t)window->height;
    for ( int c = 0; c < *stride && result == RF_OK; ++c )
    {
        for ( size_t i = 0; i < pixels && negated[c]; ++i )
            ( *values )[i * (size_t)*stride + (size_t)c] *= -1.0f;
    }
    return result;
}

RfResult rf_read_passes( const char* path, const RfFilePass* passes, int count, RfExrWindow* window, float** values, int* stride,
                         RfError* error )
{
    size_t clipped;
    return read_passes( path, passes, count, window, values, stride, &clipped, error );
}

// Three channels or one, in the words of rf_read_exr_layer.
static void name_channels( const RfExrHeader* header, const RfFilePass* pass, char* text )
{
    const char* own[3] = { "", "", "" };
    int count = pass->all_channels >= 3 ? 3 : 1;
    for ( int i = 0; i < count; ++i )
        own[i] = rf_find_exr_name( header, pass->channels[i], strlen( pass->channels[i] ) )->own;
    bool by_part = strchr( own[0], '.' ) == NULL && own[0] != pass->channels[0];
    if ( by_part && count == 3 && pass->look == RF_LOOK_LIGHT ) // "R" may be of any part
        snprintf( text, RF_PASS_LAYER_SIZE, "%s", pass->layer );
    else
        snprintf( text, RF_PASS_LAYER_SIZE, "%s%s%s%s%s", own[0], count == 3 ? "," : "", own[1], count == 3 ? "," : "", own[2] );
}

const char* rf_layer_of_file( const char* path, const char* name, char* text )
{
    RfExrHeader header;
    RfFilePasses passes;
    if ( name == NULL || rf_read_exr_header( path, NULL, &header, NULL ) != RF_OK )
        return name;
    const RfFilePass* pass = rf_list_passes( &header, &passes, NULL ) == RF_OK ? rf_find_pass( &passes, name ) : NULL;
    bool found = pass != NULL && pass->look != RF_LOOK_MATTES;
    if ( found )
        name_channels( &header, pass, text );
    rf_free_passes( &passes );
    rf_destroy_exr_header( &header );
    return found ? text : name;
}

static RfResult read_three( const char* path, const RfFilePass* pass, RfImage* image, RfExrWindow* window, size_t* clipped,
                            RfError* error )
{
    RfFilePass three = *pass;
    float* values;
    int stride;
    three.channel_count = pass->all_channels < 3 ? pass->all_channels : 3;
    RfResult result = read_passes( path, &three, 1, window, &values, &stride, clipped, error );
    if ( result == RF_OK )
        result = rf_create_image( window->width, window->height, image, error );
    size_t pixels = (size_t)image->width * (size_t)image->height;
    for ( size_t i = 0; i < 3 * pixels && result == RF_OK; ++i )
    {
        size_t c = stride == 1 ? 0 : i % 3;
        image->rgb[i] = c < (size_t)stride ? values[i / 3 * (size_t)stride + c] : 0.0f;
    }
    free( values );
    return result;
}

RfResult rf_read_pass_image( const char* path, const char* name, RfImage* image, RfExrWindow* window, size_t* clipped,
                             RfError* error )
{
    RfExrHeader header;
    RfFilePasses passes = { 0 };
    RfError here;
    char all[600] = "the colour alone";
    *image = ( RfImage ){ 0 };
    RfResult result = name != NULL ? rf_read_exr_header( path, NULL, &header, error ) : RF_OK;
    if ( name == NULL )
        return rf_read_exr_picture( path, NULL, image, window, clipped, error );
    if ( result == RF_OK )
        result = rf_list_passes( &header, &passes, error );
    const RfFilePass* pass = result == RF_OK ? rf_find_pass( &passes, name ) : NULL;
    if ( pass != NULL && pass->look != RF_LOOK_MATTES )
        result = read_three( path, pass, image, window, clipped, error );
    else if ( result == RF_OK )
    {
        result = rf_read_exr_picture( path, name, image, window, clipped, &here );
        if ( passes.count > 0 )
            rf_name_passes( &passes, all, sizeof all );
        if ( result == RF_ERROR_FORMAT && pass != NULL )
            rf_fail( error, result, "%.400s: %.100s has ids of names, which are not compared", path, name );
        else if ( result == RF_ERROR_FORMAT )
            rf_fail( error, result, "%.400s: has no layer %.100s; it has %s", path, name, all );
        else if ( result != RF_OK )
            rf_fail( error, result, "%s", here.text );
    }
    rf_free_passes( &passes );
    rf_destroy_exr_header( &header );
    return result;
}

RfLookRange rf_pass_range( const RfFilePass* pass, const float* values, size_t stride, size_t pixels )
{
    RfLookRange range = rf_look_range( pass->look, values, stride, pixels );
    if ( strcmp( pass->name, rf_aov_name( RF_AOV_ALPHA ) ) == 0 )
        range = ( RfLookRange ){ 0.0f, 1.0f };
    return range;
}

void rf_draw_pass( const RfFilePass* pass, RfLookRange range, const float* values, size_t stride, size_t pixels, float* rgb )
{
    if ( pass->look == RF_LOOK_MATTES )
        rf_draw_mattes( values, pass->channel_count / 2, stride, pixels, rgb );
    else
        rf_draw_look( pass->look, range, values, stride, pixels, rgb );
}
