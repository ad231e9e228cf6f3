#include "image/exr_channels.h"

#include <stdio.h>
#include <string.h>

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

static bool find_layer( const exr_attr_chlist_t* list, const char* prefix, size_t length, RfExrChannels* channels )
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
        if ( length < 3 || strcmp( name + length - 2, ".R" ) != 0 || !find_layer( list, name, length - 1, &found ) )
            continue;
        bool is_combined = ends_with_combined( name, length - 1 );
        *layers += 1;
        *combined += is_combined;
        if ( *layers == 1 || is_combined )
            *channels = found;
        append_name( text, size, name, length - 2 );
    }
}

void rf_list_exr_channels( const exr_attr_chlist_t* list, char* text, size_t size )
{
    for ( int i = 0; i < list->num_channels; ++i )
        append_name( text, size, list->entries[i].name.str, strlen( list->entries[i].name.str ) );
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
    rf_list_exr_channels( list, text, sizeof text );
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

RfResult rf_find_exr_channels( const RfExrStream* stream, const exr_attr_chlist_t* list, const char* advice,
                               RfExrChannels* channels, RfError* error )
{
    int layers = 0, combined = 0;
    char text[512] = "";
    if ( !find_layer( list, "", 0, channels ) )
    {
        find_layers( list, channels, &layers, &combined, text, sizeof text );
        channels->count = layers;
        if ( layers > 1 && combined != 1 )
            return rf_fail( error, RF_ERROR_UNSUPPORTED, "%s: has more than one layer of colour: %s: %s", stream->path, text,
                            advice );
        channels->count = layers == 0 ? 0 : 3;
        RfResult result = layers == 0 ? find_luminance( stream, list, channels, error ) : RF_OK;
        if ( result != RF_OK )
            return result;
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

bool rf_find_exr_layer( const RfExrPart* part, const char* layer, RfExrChannels* channels )
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
    if ( find_layer( part->channels, prefix, (size_t)length, channels ) ||
         find_three( part->channels, prefix, (size_t)length, axes, channels ) )
        return true;
    return exr_get_name( part->context, part->index, &name ) == EXR_ERR_SUCCESS && name != NULL && strcmp( name, layer ) == 0 &&
           rf_find_exr_channels( part->stream, part->channels, "", channels, NULL ) == RF_OK;
}
