#include "cli/report/report_layers.h"

#include "cli/messages.h"
#include "page/picture.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LEAST_BITS 2.5 // per pixel; pictures are made smaller rather than coarser

// The usual names, of Reframe and of Blender: the first channel; the others follow by their letters.
static const struct
{
    const char* name;
    RfLook look;
    const char *tails[3], *letters;
} s_known[RF_PAGE_MOST_LAYERS] = {
    { "albedo", RF_LOOK_LIGHT, { "albedo.R", "DiffCol.R" }, "RGB" },
    { "normal", RF_LOOK_NORMAL, { "normal.X", "Normal.X" }, "XYZ" },
    { "depth", RF_LOOK_DEPTH, { "depth.Z", "Depth.Z", "Depth.V" }, "" },
    { "motion", RF_LOOK_MOTION, { "motion.X", "Vector.X" }, "XY" },
    { "variance", RF_LOOK_DEVIATION, { "variance.R" }, "RGB" },
    { "samples", RF_LOOK_SHARE, { "samples.Y" }, "" },
    { "alpha", RF_LOOK_SHARE, { "A", "Combined.A" }, "" },
};

static bool is_at_picture( const RfExrName* channel, const RfExrHeader* header )
{
    const RfExrWindow* w = &channel->window;
    return w->x == header->x && w->y == header->y && w->width == header->width && w->height == header->height;
}

static const char* find_tail( const RfExrHeader* header, const char* tail )
{
    size_t end = strlen( tail );
    for ( int i = 0; i < header->channel_count; ++i )
    {
        const char* name = header->channels[i].text;
        size_t length = strlen( name );
        if ( length >= end && strcmp( name + length - end, tail ) == 0 && ( length == end || name[length - end - 1] == '.' ) &&
             is_at_picture( header->channels + i, header ) )
            return name;
    }
    return NULL;
}

// The channel with the same name but for the last letter.
static const char* find_sister( const RfExrHeader* header, const char* first, char letter )
{
    size_t length = strlen( first );
    for ( int i = 0; i < header->channel_count; ++i )
    {
        const char* name = header->channels[i].text;
        if ( strlen( name ) == length && memcmp( name, first, length - 1 ) == 0 && name[length - 1] == letter &&
             is_at_picture( header->channels + i, header ) )
            return name;
    }
    return NULL;
}

static bool find_layer( const RfExrHeader* header, size_t known, RfPageLayer* layer )
{
    *layer = ( RfPageLayer ){ .name = s_known[known].name, .look = s_known[known].look };
    for ( size_t t = 0; t < 3 && s_known[known].tails[t] != NULL && layer->channels[0] == NULL; ++t )
        layer->channels[0] = find_tail( header, s_known[known].tails[t] );
    bool is_there = layer->channels[0] != NULL;
    for ( int c = 1; c < rf_look_channels( layer->look ) && is_there; ++c )
    {
        layer->channels[c] = find_sister( header, layer->channels[0], s_known[known].letters[c] );
        is_there = layer->channels[c] != NULL;
    }
    return is_there;
}

// Reads the channels of all layers at once: `count` floats for each pixel. NULL where the file lacks one.
static float* read_all( const RfPageLayers* layers, const char* path, RfExrWindow* window, int* count )
{
    const char* names[3 * RF_PAGE_MOST_LAYERS];
    float* values = NULL;
    *count = 0;
    for ( int i = 0; i < layers->count; ++i )
    {
        for ( int c = 0; c < rf_look_channels( layers->layers[i].look ); ++c )
            names[( *count )++] = layers->layers[i].channels[c];
    }
    return rf_read_exr_channels( path, names, *count, window, &values, NULL ) == RF_OK ? values : NULL;
}

static void choose_factor( const RfExrHeader* header, int pictures, double share, RfPageLayers* layers )
{
    double bits = share / ( (double)layers->count * pictures ) * 0.75 * 8.0; // of a picture
    layers->factor = (int)ceil( sqrt( (double)header->width * header->height * LEAST_BITS / bits ) );
    layers->factor = layers->factor < 1 ? 1 : layers->factor;
    layers->width = ( header->width + layers->factor - 1 ) / layers->factor;
    layers->height = ( header->height + layers->factor - 1 ) / layers->factor;
    layers->bits = fmin( bits / ( (double)layers->width * layers->height ), RF_PICTURE_MAX_BITS );
}

void rf_find_page_layers( const RfPageSequence* sequence, const char* typical, int pictures, double share, RfPageLayers* layers )
{
    *layers = ( RfPageLayers ){ 0 };
    for ( size_t i = 0; i < RF_PAGE_MOST_LAYERS && pictures > 0; ++i )
        layers->count += find_layer( &sequence->header, i, layers->layers + layers->count );
    if ( layers->count == 0 )
        return;
    choose_factor( &sequence->header, pictures, share, layers );
    RfExrWindow window;
    int stride, at = 0;
    float* values = read_all( layers, typical, &window, &stride );
    if ( values == NULL )
        layers->count = 0;
    for ( int i = 0; i < layers->count; ++i )
    {
        RfPageLayer* layer = layers->layers + i;
        layer->range = rf_look_range( layer->look, values + at, (size_t)stride, (size_t)window.width * (size_t)window.height );
        if ( strcmp( layer->name, "alpha" ) == 0 )
            layer->range = ( RfLookRange ){ 0.0f, 1.0f };
        at += rf_look_channels( layer->look );
    }
    free( values );
}

// Draws a layer at full size, shrinks and adds it.
static RfResult add_one( RfPage* page, const RfPageLayers* layers, int index, const char* id, const float* values, int stride,
                         RfImage* full, const char* path, RfError* error )
{
    const RfPageLayer* layer = layers->layers + index;
    RfImage small = { 0 };
    unsigned char* bytes = NULL;
    size_t size = 0;
    rf_draw_look( layer->look, layer->range, values, (size_t)stride, (size_t)full->width * (size_t)full->height, full->rgb );
    RfResult result = layers->factor > 1 ? rf_shrink_image( full, layers->factor, &small, error ) : RF_OK;
    if ( result == RF_OK )
        result = rf_encode_picture_within( layers->factor > 1 ? &small : full, layers->bits, path, &bytes, &size, error );
    if ( result == RF_OK )
        result = rf_add_page_block( page, id, bytes, size, error );
    free( bytes );
    rf_destroy_image( &small );
    return result;
}

RfResult rf_add_page_layers( RfPage* page, const RfPageLayers* layers, int track, int number, const char* path, bool* added,
                             RfError* error )
{
    RfExrWindow window;
    RfImage full;
    int stride, at = 0;
    *added = false;
    if ( layers->count == 0 )
        return RF_OK;
    float* values = read_all( layers, path, &window, &stride );
    if ( values == NULL )
        return RF_OK;
    RfResult result = rf_create_image( window.width, window.height, &full, error );
    for ( int i = 0; i < layers->count && result == RF_OK; ++i )
    {
        char id[48];
        snprintf( id, sizeof id, "l%d-%d-%d", track, i, number );
        result = add_one( page, layers, i, id, values + at, stride, &full, path, error );
        at += rf_look_channels( layers->layers[i].look );
    }
    *added = result == RF_OK;
    rf_destroy_image( &full );
    free( values );
    return result;
}

json_t* rf_page_layers_json( const RfPageLayers* layers )
{
    static const char* const looks[] = { "light", "deviation", "normal", "depth", "motion", "share" };
    json_t* list = json_array();
    for ( int i = 0; i < layers->count; ++i )
    {
        const RfPageLayer* layer = layers->layers + i;
        json_array_append_new( list,
                               json_pack( "{s:s, s:s, s:o, s:o, s:i, s:i, s:i}", "name", layer->name, "look", looks[layer->look],
                                          "low", rf_json_number( layer->range.low ), "high", rf_json_number( layer->range.high ),
                                          "factor", layers->factor, "width", layers->width, "height", layers->height ) );
    }
    return list;
}
