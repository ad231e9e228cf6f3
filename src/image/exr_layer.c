// Finds the channels of a layer in an EXR by the naming conventions of renderers, and reads them.
#include "base/try.h"
#include "image/exr_stream.h"

#include "base/remedy.h"
#include "image/exr.h"
#include "image/half.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

// Finds the channel whose name is the first `length` characters of `prefix` followed by
// `suffix`.
static const exr_attr_chlist_entry_t* find_channel( const exr_attr_chlist_t* list, const char* prefix, size_t length,
                                                    const char* suffix )
{
    for ( int i = 0; i < list->num_channels; ++i )
    {
        const char* name = list->entries[i].name.str;
        if ( strlen( name ) >= length && memcmp( name, prefix, length ) == 0 && strcmp( name + length, suffix ) == 0 )
            return list->entries + i;
    }
    return NULL;
}

// Fills `channels` if all three of a layer exist; `length` includes the dot.
static bool find_three( const exr_attr_chlist_t* list, const char* prefix, size_t length, const char* const suffixes[3],
                        RfExrChannels* channels )
{
    RfExrChannels found = { .count = 3 };
    for ( int c = 0; c < 3; ++c )
    {
        const exr_attr_chlist_entry_t* entry = find_channel( list, prefix, length, suffixes[c] );
        if ( entry == NULL )
            return false;
        found.names[c] = entry->name.str;
    }
    *channels = found;
    return true;
}

static bool find_layer_colour( const exr_attr_chlist_t* list, const char* prefix, size_t length, RfExrChannels* channels )
{
    static const char* const suffixes[3] = { "R", "G", "B" };
    return find_three( list, prefix, length, suffixes, channels );
}

static bool ends_with_combined( const char* name, size_t length )
{
    static const char word[] = "Combined.";
    size_t size = sizeof word - 1;
    return length >= size && memcmp( name + length - size, word, size ) == 0;
}

static void append_name( char* text, size_t size, const char* name, size_t length )
{
    size_t used = strlen( text );
    snprintf( text + used, size - used, "%s%.*s", used > 0 ? ", " : "", (int)length, name );
}

// Counts the layers and those named "…Combined"; if the counts leave one choice, `channels`
// receives it.
static void find_layers( const exr_attr_chlist_t* list, RfExrChannels* channels, int* layers, int* combined, char* text,
                         size_t size )
{
    for ( int i = 0; i < list->num_channels; ++i )
    {
        const char* name = list->entries[i].name.str;
        size_t length = strlen( name );
        RfExrChannels found;
        if ( length < 3 || strcmp( name + length - 2, ".R" ) != 0 || !find_layer_colour( list, name, length - 1, &found ) )
            continue;
        bool is_combined = ends_with_combined( name, length - 1 );
        *layers += 1;
        *combined += is_combined;
        if ( *layers == 1 || is_combined )
            *channels = found;
        append_name( text, size, name, length - 2 );
    }
}

// Lists the names of all layers, and of channels that are in none, separated by commas.
static void list_layers( const exr_attr_chlist_t* list, char* text, size_t size )
{
    for ( int i = 0; i < list->num_channels; ++i ) // sorted: those of a layer follow each other
    {
        const char *name = list->entries[i].name.str, *dot = strrchr( name, '.' );
        size_t length = dot != NULL ? (size_t)( dot - name ) : strlen( name );
        if ( dot == NULL || i == 0 || strncmp( list->entries[i - 1].name.str, name, length + 1 ) != 0 ||
             strchr( list->entries[i - 1].name.str + length + 1, '.' ) != NULL )
            append_name( text, size, name, length );
    }
}

static RfResult find_luminance( const RfExrStream* stream, const exr_attr_chlist_t* list, RfExrChannels* channels,
                                RfError* error )
{
    const exr_attr_chlist_entry_t* entry = find_channel( list, "", 0, "Y" );
    if ( entry != NULL && ( find_channel( list, "", 0, "RY" ) != NULL || find_channel( list, "", 0, "BY" ) != NULL ) )
        return rf_fail( error, RF_ERROR_UNSUPPORTED, "%s: is stored as luminance and chroma (Y, RY, BY): convert it to R, G, B",
                        stream->path );
    if ( entry != NULL )
    {
        *channels = ( RfExrChannels ){ .names = { entry->name.str }, .count = 1 };
        return RF_OK;
    }
    char text[512] = "";
    list_layers( list, text, sizeof text );
    return rf_fail( error, RF_ERROR_UNSUPPORTED, "%s: has no channels R, G, B and no Y; it has %s", stream->path,
                    text[0] != 0 ? text : "none" );
}

RfResult rf_check_exr_channel( const RfExrStream* stream, const exr_attr_chlist_t* list, const char* name, RfError* error )
{
    const exr_attr_chlist_entry_t* entry = find_channel( list, "", 0, name );
    if ( entry == NULL )
        return rf_fail( error, RF_ERROR_FORMAT, "%s: has no channel %s", stream->path, name );
    if ( entry->x_sampling != 1 || entry->y_sampling != 1 )
        return rf_fail( error, RF_ERROR_UNSUPPORTED, "%s: channel %s is subsampled: store it at full resolution", stream->path,
                        name );
    return RF_OK;
}

// Finds the colour: R, G, B; else a layer P with P.R, P.G and P.B, if it is the only one or
// the only one whose name ends with "Combined"; else Y. Otherwise the error lists the channels
// or layers, `remedy` is that of several layers (RF_REMEDY_LAYER or none), and channels->count is their
// number.
static RfResult find_exr_channels( const RfExrStream* stream, const exr_attr_chlist_t* list, RfRemedy remedy,
                                   RfExrChannels* channels, RfError* error )
{
    int layers = 0, combined = 0;
    char text[512] = "";
    if ( !find_layer_colour( list, "", 0, channels ) )
    {
        find_layers( list, channels, &layers, &combined, text, sizeof text );
        channels->count = layers;
        if ( layers > 1 && combined != 1 )
            return rf_advise( rf_fail( error, RF_ERROR_UNSUPPORTED, "%s: has more than one layer of colour: %s%s", stream->path,
                                       text, remedy == RF_REMEDY_NONE ? ": keep one" : "" ),
                              remedy, 0, error );
        channels->count = layers == 0 ? 0 : 3;
        RF_TRY( layers == 0 ? find_luminance( stream, list, channels, error ) : RF_OK );
    }
    RfResult result = RF_OK;
    for ( int c = 0; c < channels->count && result == RF_OK; ++c )
        result = rf_check_exr_channel( stream, list, channels->names[c], error );
    return result;
}

// Finds three channels "a,b,c".
static bool find_named( const exr_attr_chlist_t* list, const char* names, RfExrChannels* channels )
{
    RfExrChannels found = { .count = 3 };
    for ( int c = 0; c < 3; ++c )
    {
        size_t length = strcspn( names, "," );
        const exr_attr_chlist_entry_t* entry = length > 0 ? find_channel( list, names, length, "" ) : NULL;
        if ( entry == NULL || ( names[length] == ',' ) != ( c < 2 ) )
            return false;
        found.names[c] = entry->name.str;
        names += length + ( c < 2 );
    }
    *channels = found;
    return true;
}

// Finds the channels that `layer` names in this part: a channel (as grey), the three of a
// layer (P.R, P.G, P.B or P.X, P.Y, P.Z), three channels separated by commas, or the colour of
// the part if it is the part's name. False if there are none.
static bool find_exr_layer( const RfExrPart* part, const char* layer, RfExrChannels* channels )
{
    static const char* const axes[3] = { "X", "Y", "Z" };
    const exr_attr_chlist_entry_t* entry = find_channel( part->channels, "", 0, layer );
    const char* name = NULL;
    char prefix[256];
    if ( entry != NULL )
    {
        *channels = ( RfExrChannels ){ .names = { entry->name.str }, .count = 1 };
        return true;
    }
    if ( find_named( part->channels, layer, channels ) )
        return true;
    int length = snprintf( prefix, sizeof prefix, "%s.", layer );
    if ( length < 0 || (size_t)length >= sizeof prefix )
        return false;
    if ( find_layer_colour( part->channels, prefix, (size_t)length, channels ) ||
         find_three( part->channels, prefix, (size_t)length, axes, channels ) )
        return true;
    return exr_get_name( part->context, part->index, &name ) == EXR_ERR_SUCCESS && name != NULL && strcmp( name, layer ) == 0 &&
           find_exr_channels( part->stream, part->channels, RF_REMEDY_NONE, channels, NULL ) == RF_OK;
}

// Reads the colour or any other layer, with its data window, from files of any program,
// including multi-part files.

// Opens the colour of a part; on failure channels->count is the number of colour layers.
static RfResult open_colour( RfExrStream* stream, int index, RfExrPart* part, RfExrChannels* channels, RfError* error )
{
    *channels = ( RfExrChannels ){ 0 };
    RF_TRY( rf_open_exr_part( stream, index, part, error ) );
    RfResult result = find_exr_channels( stream, part->channels, RF_REMEDY_LAYER, channels, error );
    if ( result != RF_OK )
        rf_close_exr_part( part );
    return result;
}

// Finds the first part with three colour channels, else the first with Y, since a Y may also
// belong to X and Y of a vector. On failure reports the first part that has several colour
// layers, else the first part.
static RfResult find_colour( RfExrStream* stream, RfExrPart* part, RfExrChannels* channels, RfError* error )
{
    int count = 1, grey = -1;
    bool has_several = false;
    RfError first = { 0 };
    for ( int i = 0; i < count; ++i )
    {
        RfError here = { 0 };
        RfResult result = open_colour( stream, i, part, channels, &here );
        count = part->count;
        if ( result == RF_OK && channels->count == 3 )
            return RF_OK;
        if ( result == RF_OK )
        {
            grey = grey < 0 ? i : grey;
            rf_close_exr_part( part );
            continue;
        }
        if ( first.code == RF_OK || ( channels->count > 1 && !has_several ) )
            first = here;
        has_several |= channels->count > 1;
    }
    if ( grey >= 0 && !has_several )
        return open_colour( stream, grey, part, channels, error );
    return rf_advise( rf_fail( error, first.code, "%s", first.text ), first.remedy, 0, error );
}

static RfResult find_layer( RfExrStream* stream, const char* layer, RfExrPart* part, RfExrChannels* channels, RfError* error )
{
    char text[512] = "";
    int count = 1;
    for ( int i = 0; i < count; ++i )
    {
        RfResult result = rf_open_exr_part( stream, i, part, error );
        if ( result != RF_OK && part->count <= 1 )
            return result;
        count = part->count;
        if ( result != RF_OK )
            continue;
        if ( find_exr_layer( part, layer, channels ) )
            return RF_OK;
        list_layers( part->channels, text, sizeof text );
        rf_close_exr_part( part );
    }
    return rf_fail( error, RF_ERROR_FORMAT, "%s: has no layer %s; it has %s", stream->path, layer, text[0] != 0 ? text : "none" );
}

RfResult rf_open_exr_layer( RfExrStream* stream, const char* layer, RfExrPart* part, RfExrChannels* channels, RfError* error )
{
    return layer != NULL ? find_layer( stream, layer, part, channels, error ) : find_colour( stream, part, channels, error );
}

static bool is_half_channel( const RfExrPart* part, const char* name )
{
    const exr_attr_chlist_entry_t* entry = find_channel( part->channels, "", 0, name );
    return entry != NULL && entry->pixel_type == EXR_PIXEL_HALF;
}

// Pixels with a value at the end of the range of half floats, or beyond.
static size_t count_clipped( const float* values, size_t pixels, const bool* half, int channels )
{
    size_t count = 0;
    for ( size_t i = 0; i < pixels; ++i, values += channels )
    {
        bool any = false;
        for ( int c = 0; c < channels; ++c )
            any = any || ( half[c] && isgreaterequal( fabsf( values[c] ), RF_HALF_MAX ) ); // not for NaN
        count += any;
    }
    return count;
}

static void take_value( void* user, int channel, int x, int y, const float* values, int count )
{
    RfImage* image = user;
    float* out = image->rgb + 3 * ( (size_t)y * (size_t)image->width + (size_t)x ) + channel;
    for ( int i = 0; i < count; ++i )
        out[3 * i] = values[i];
}

static bool is_letter( const char* word, int c )
{
    static const char* const s_words[3][3] = { { "R", "r", "red" }, { "G", "g", "green" }, { "B", "b", "blue" } };
    return strcmp( word, s_words[c][0] ) == 0 || strcmp( word, s_words[c][1] ) == 0 || strcmp( word, s_words[c][2] ) == 0;
}

// What R, G and B of a layer are: ids of a Cryptomatte, by any word of its name, a variance by the last, or a colour.
static RfColourKind kind_of_layer( const char* layer, size_t length )
{
    static const char ids[] = "crypto", variance[] = "variance";
    const char *end = layer + length, *word = layer;
    for ( const char* c = layer; c < end; ++c )
    {
        bool begins = c == layer || c[-1] == '.';
        if ( begins && strncasecmp( c, ids, strlen( ids ) ) == 0 )
            return RF_COLOUR_NONE;
        word = begins ? c : word;
    }
    bool is_variance = (size_t)( end - word ) == strlen( variance ) && strncmp( word, variance, strlen( variance ) ) == 0;
    return is_variance ? RF_COLOUR_VARIANCE : RF_COLOUR_LIGHT;
}

static RfColourKind kind_of( const char* const names[3] )
{
    const char* dots[3];
    for ( int c = 0; c < 3; ++c )
    {
        dots[c] = strrchr( names[c], '.' );
        if ( !is_letter( dots[c] != NULL ? dots[c] + 1 : names[c], c ) )
            return RF_COLOUR_NONE;
        size_t length = dots[0] != NULL ? (size_t)( dots[0] - names[0] ) : 0,
               here = dots[c] != NULL ? (size_t)( dots[c] - names[c] ) : 0;
        if ( here != length || strncmp( names[c], names[0], length ) != 0 )
            return RF_COLOUR_NONE;
    }
    return kind_of_layer( names[0], dots[0] != NULL ? (size_t)( dots[0] - names[0] ) : 0 );
}

static RfResult find_conversion( const RfExrPart* part, const char* const names[3], RfColourKind* kind,
                                 RfColourConversion* conversion, RfError* error )
{
    const char* name = NULL;
    *kind = kind_of( names );
    *conversion = ( RfColourConversion ){ .needed = false };
    if ( *kind == RF_COLOUR_LIGHT && strchr( names[0], '.' ) == NULL && part->count > 1 &&
         exr_get_name( part->context, part->index, &name ) == EXR_ERR_SUCCESS && name != NULL ) // the part is the layer
        *kind = kind_of_layer( name, strlen( name ) );
    return *kind != RF_COLOUR_NONE ? rf_read_exr_colours( part, conversion, error ) : RF_OK;
}

// `left`: gets the conversion to Rec. 709, which the caller makes; NULL: it is made.
static RfResult read_image( const RfExrPart* part, const RfExrChannels* channels, RfImage* image, size_t* clipped,
                            RfColourConversion* left, RfError* error )
{
    RfColourKind kind = RF_COLOUR_NONE;
    RfColourConversion conversion = { .needed = false };
    RfResult result = channels->count == 3 ? find_conversion( part, channels->names, &kind, &conversion, error ) : RF_OK;
    if ( left != NULL )
        *left = conversion;
    if ( result == RF_OK )
        result = rf_create_image( part->width, part->height, image, error );
    // duplicate channels are read once, then copied
    if ( result == RF_OK )
        result = rf_read_exr_lines( part, channels->names, channels->count, take_value, image, error );
    int like[3] = { 0, channels->count == 1 ? 0 : 1, channels->count == 1 ? 0 : 2 };
    for ( int c = channels->count - 1; c > 0; --c )
    {
        for ( int d = c - 1; d >= 0; --d )
            like[c] = strcmp( channels->names[d], channels->names[c] ) == 0 ? d : like[c];
    }
    size_t pixels = (size_t)part->width * (size_t)part->height;
    bool half[3];
    for ( int c = 0; c < 3; ++c )
        half[c] = is_half_channel( part, channels->names[like[c]] );
    for ( size_t i = 0; result == RF_OK && i < pixels; ++i )
    {
        image->rgb[3 * i + 1] = image->rgb[3 * i + (size_t)like[1]];
        image->rgb[3 * i + 2] = image->rgb[3 * i + (size_t)like[2]];
    }
    if ( result == RF_OK )
    {
        *clipped = count_clipped( image->rgb, pixels, half, 3 );
        rf_convert_colours( &conversion, left == NULL ? kind : RF_COLOUR_NONE, image->rgb, pixels, 3 );
    }
    else
        rf_destroy_image( image );
    return result;
}

RfResult rf_read_exr_picture( const char* path, const char* layer, RfImage* image, RfExrWindow* window, size_t* clipped,
                              RfError* error )
{
    *image = ( RfImage ){ 0 };
    *clipped = 0;
    RfExrStream stream;
    RF_TRY( rf_open_exr_file( path, &stream, error ) );
    RfExrPart part;
    RfExrChannels channels;
    RfResult result = rf_open_exr_layer( &stream, layer, &part, &channels, error );
    if ( result == RF_OK )
    {
        result = read_image( &part, &channels, image, clipped, NULL, error );
        *window = ( RfExrWindow ){ part.window.min.x, part.window.min.y, part.width, part.height };
        rf_close_exr_part( &part );
    }
    close( stream.fd );
    return result;
}

RfResult rf_read_exr_stream( RfExrStream* stream, RfImage* image, RfColourConversion* conversion, RfError* error )
{
    RfExrPart part;
    RfExrChannels channels;
    size_t clipped;
    *image = ( RfImage ){ 0 };
    RF_TRY( rf_open_exr_part( stream, 0, &part, error ) );
    RfResult result = find_exr_channels( stream, part.channels, RF_REMEDY_NONE, &channels, error );
    if ( result == RF_OK )
        result = read_image( &part, &channels, image, &clipped, conversion, error );
    rf_close_exr_part( &part );
    return result;
}

RfResult rf_read_exr( const char* path, RfImage* image, RfError* error )
{
    RfExrStream stream;
    RfColourConversion conversion;
    *image = ( RfImage ){ 0 };
    RF_TRY( rf_open_exr_file( path, &stream, error ) );
    RfResult result = rf_read_exr_stream( &stream, image, &conversion, error );
    close( stream.fd );
    if ( result == RF_OK )
        rf_convert_colours( &conversion, RF_COLOUR_LIGHT, image->rgb, (size_t)image->width * (size_t)image->height, 3 );
    return result;
}

RfResult rf_read_exr_layer( const char* path, const char* layer, RfImage* image, RfExrWindow* window, RfError* error )
{
    size_t clipped;
    return rf_read_exr_picture( path, layer, image, window, &clipped, error );
}

// The channels of one part and their positions in the interleaved output.
typedef struct Interleaved
{
    float* values;
    int width, channels;
    const char* names[RF_EXR_MAX_CHANNELS];
    int places[RF_EXR_MAX_CHANNELS];
    int count;
    bool half[RF_EXR_MAX_CHANNELS];                      // by place
    RfColourConversion conversions[RF_EXR_MAX_CHANNELS]; // of three channels from a place on
    RfColourKind kinds[RF_EXR_MAX_CHANNELS];
} Interleaved;

static void take_channel( void* user, int channel, int x, int y, const float* values, int count )
{
    const Interleaved* to = user;
    float* out = to->values + (size_t)to->channels * ( (size_t)y * (size_t)to->width + (size_t)x ) + to->places[channel];
    for ( int i = 0; i < count; ++i )
        out[(size_t)i * (size_t)to->channels] = values[i];
}

// Colours among the channels: three of a layer that follow each other.
static RfResult find_colours( const RfExrPart* part, const RfExrName* const* wanted, Interleaved* to, RfError* error )
{
    RfResult result = RF_OK;
    for ( int i = 0; i + 2 < to->count && result == RF_OK; ++i )
    {
        int place = to->places[i];
        if ( to->places[i + 2] != place + 2 )
            continue;
        const char* const names[3] = { wanted[place]->text, wanted[place + 1]->text, wanted[place + 2]->text };
        result = find_conversion( part, names, to->kinds + place, to->conversions + place, error );
    }
    return result;
}

static RfResult read_part( RfExrStream* stream, int index, const RfExrName* const* wanted, Interleaved* to, RfError* error )
{
    RfExrPart part;
    RF_TRY( rf_open_exr_part( stream, index, &part, error ) );
    for ( int i = 0; i < to->count; ++i )
        to->half[to->places[i]] = is_half_channel( &part, to->names[i] );
    RfResult result = find_colours( &part, wanted, to, error );
    if ( result == RF_OK )
        result = rf_read_exr_lines( &part, to->names, to->count, take_channel, to, error );
    rf_close_exr_part( &part );
    return result;
}

// Reads part by part, each with its requested channels.
static RfResult read_parts( RfExrStream* stream, const RfExrName* const* wanted, int count, Interleaved* to, RfError* error )
{
    RfResult result = RF_OK;
    for ( int i = 0; i < count && result == RF_OK; ++i )
    {
        bool is_done = false;
        for ( int k = 0; k < i; ++k )
            is_done |= wanted[k]->part == wanted[i]->part;
        if ( is_done )
            continue;
        to->count = 0;
        for ( int k = i; k < count; ++k )
        {
            if ( wanted[k]->part != wanted[i]->part )
                continue;
            to->names[to->count] = wanted[k]->own;
            to->places[to->count++] = k;
        }
        result = read_part( stream, wanted[i]->part, wanted, to, error );
    }
    return result;
}

static RfResult find_wanted( const char* path, const RfExrHeader* header, const char* const* names, int count,
                             const RfExrName** wanted, RfError* error )
{
    for ( int i = 0; i < count; ++i )
    {
        wanted[i] = rf_find_exr_name( header, names[i], strlen( names[i] ) );
        if ( wanted[i] == NULL )
            return rf_fail( error, RF_ERROR_FORMAT, "%s: has no channel %s", path, names[i] );
        const RfExrWindow *first = &wanted[0]->window, *now = &wanted[i]->window;
        if ( memcmp( first, now, sizeof *now ) != 0 )
            return rf_fail( error, RF_ERROR_FORMAT,
                            "%.400s: %.64s has %dx%d pixels from (%d, %d) on, %.64s %dx%d from (%d, %d) on: "
                            "store all parts with the same data window",
                            path, names[0], first->width, first->height, first->x, first->y, names[i], now->width, now->height,
                            now->x, now->y );
    }
    return RF_OK;
}

static RfResult read_wanted( const char* path, const RfExrName* const* wanted, int count, float** values, size_t* clipped,
                             RfError* error )
{
    const RfExrWindow* window = &wanted[0]->window;
    RfExrStream stream;
    RF_TRY( rf_open_exr_file( path, &stream, error ) );
    Interleaved to = { .width = window->width, .channels = count };
    to.values = malloc( (size_t)window->width * (size_t)window->height * (size_t)count * sizeof( float ) );
    RfResult result = RF_OK;
    if ( to.values == NULL )
        result = rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory for %dx%d pixels", path, window->width, window->height );
    else
        result = read_parts( &stream, wanted, count, &to, error );
    close( stream.fd );
    if ( result != RF_OK )
    {
        free( to.values );
        return result;
    }
    *values = to.values;
    size_t pixels = (size_t)window->width * (size_t)window->height;
    *clipped = count_clipped( to.values, pixels, to.half, count );
    for ( int i = 0; i + 2 < count; ++i )
        rf_convert_colours( to.conversions + i, to.kinds[i], to.values + i, pixels, (size_t)count );
    return RF_OK;
}

RfResult rf_read_exr_values( const char* path, const char* const* names, int count, RfExrWindow* window, float** values,
                             size_t* clipped, RfError* error )
{
    *values = NULL;
    *clipped = 0;
    *window = ( RfExrWindow ){ 0 };
    if ( count < 1 || count > RF_EXR_MAX_CHANNELS )
        return rf_fail( error, RF_ERROR_USAGE, "%s: cannot read %d channels: ask for 1 to %d", path, count, RF_EXR_MAX_CHANNELS );
    RfExrHeader header;
    const RfExrName* wanted[RF_EXR_MAX_CHANNELS];
    RF_TRY( rf_read_exr_header( path, NULL, &header, error ) );
    RfResult result = find_wanted( path, &header, names, count, wanted, error );
    if ( result == RF_OK )
        result = read_wanted( path, wanted, count, values, clipped, error );
    if ( result == RF_OK )
        *window = wanted[0]->window;
    rf_destroy_exr_header( &header );
    return result;
}

RfResult rf_read_exr_channels( const char* path, const char* const* names, int count, RfExrWindow* window, float** values,
                               RfError* error )
{
    size_t clipped;
    return rf_read_exr_values( path, names, count, window, values, &clipped, error );
}
