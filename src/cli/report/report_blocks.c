#include "cli/report/report_blocks.h"

#include "page/picture.h"
#include "page/values.h"

#include <stdio.h>
#include <stdlib.h>

void rf_page_block_id( const RfPageTrack* track, int number, char id[32] ) { snprintf( id, 32, "s%d-%d", track->index, number ); }

static RfResult add_picture( RfPage* page, RfPageTrack* track, int number, const RfImage* image, const char* path,
                             RfError* error )
{
    RfImage small = { 0 };
    int factor = track->width > 0 ? ( image->width + track->width - 1 ) / track->width : 1;
    unsigned char* bytes = NULL;
    size_t size = 0;
    RfResult result = factor > 1 ? rf_shrink_image( image, factor, &small, error ) : RF_OK;
    const RfImage* picture = factor > 1 ? &small : image;
    if ( result == RF_OK )
        result = rf_encode_picture( picture, path, &bytes, &size, error );
    char id[32];
    rf_page_block_id( track, number, id );
    if ( result == RF_OK )
        result = rf_add_page_block( page, id, bytes, size, error );
    track->picture_width = picture->width;
    track->picture_height = picture->height;
    track->picture_bytes += size;
    free( bytes );
    rf_destroy_image( &small );
    return result;
}

static RfResult add_values( RfPage* page, RfPageTrack* track, const char* id, const RfImage* image, int factor, const char* path,
                            RfError* error )
{
    unsigned char* bytes;
    size_t size;
    uint64_t before = page->bytes;
    RfResult result = rf_encode_values( image, factor, path, &bytes, &size, error );
    if ( result == RF_OK )
        result = rf_add_page_block( page, id, bytes, size, error );
    track->value_bytes += page->bytes - before;
    free( bytes );
    return result;
}

RfResult rf_add_page_fine_values( RfPage* page, RfPageTrack* track, int number, int factor, RfError* error )
{
    char path[RF_PAGE_NAME_SIZE], id[32];
    RfImage image;
    RfExrWindow window;
    RfResult result = rf_page_frame_path( track->sequence, number, path, error );
    if ( result == RF_OK )
        result = rf_read_exr_layer( path, track->sequence->layer, &image, &window, error );
    if ( result != RF_OK )
        return result;
    snprintf( id, sizeof id, "w%d-%d", track->index, number );
    result = add_values( page, track, id, &image, factor, path, error );
    rf_destroy_image( &image );
    track->fine_frame = number;
    track->fine_factor = factor;
    return result;
}

RfResult rf_add_page_blocks( RfPage* page, RfPageTrack* track, int frame, const RfImage* image, const char* path, RfError* error )
{
    int number = track->numbers[frame];
    char id[32];
    RfResult result = add_picture( page, track, number, image, path, error );
    snprintf( id, sizeof id, "v%d-%d", track->index, number );
    if ( result == RF_OK && track->value_factor > 0 )
        result = add_values( page, track, id, image, track->value_factor, path, error );
    uint64_t before = page->bytes;
    if ( result == RF_OK )
        result = rf_add_page_layers( page, &track->layers, track->index, number, path, &track->frames[frame].has_layers, error );
    track->layer_bytes += page->bytes - before;
    return result;
}

RfResult rf_find_page_aovs( RfPageTrack* track, RfError* error )
{
    int pictures = 0, typical = 0;
    char path[RF_PAGE_NAME_SIZE];
    for ( int i = 0; i < track->count; ++i )
    {
        if ( !rf_has_page_frame( track->sequence, track->numbers[i] ) )
            continue;
        typical = pictures == 0 || i <= track->count / 2 ? track->numbers[i] : typical;
        ++pictures;
    }
    if ( pictures == 0 || !( track->layer_share > 0.0 ) )
        return RF_OK;
    RfResult result = rf_page_frame_path( track->sequence, typical, path, error );
    if ( result == RF_OK )
        rf_find_page_layers( track->sequence, path, pictures, track->layer_share, &track->layers );
    if ( result == RF_OK && track->layers.count == 0 ) // the middle frame may lack them
        rf_find_page_layers( track->sequence, track->sequence->first, pictures, track->layer_share, &track->layers );
    return result;
}
