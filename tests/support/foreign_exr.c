#include "support/foreign_exr.h"

#include <openexr.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static void encode( exr_context_t context, int part, const Foreign* foreign, const exr_chunk_info_t* chunk )
{
    exr_encode_pipeline_t pipeline = EXR_ENCODE_PIPELINE_INITIALIZER;
    assert_int_equal( exr_encoding_initialize( context, part, chunk, &pipeline ), EXR_ERR_SUCCESS );
    static float lines[6][1024];
    for ( int c = 0; c < pipeline.channel_count; ++c )
    {
        assert_in_range( pipeline.channels[c].width * pipeline.channels[c].height, 1, 1024 );
        for ( int i = 0; i < 1024; ++i )
            lines[c][i] = foreign->values[c];
        pipeline.channels[c].encode_from_ptr = (const uint8_t*)lines[c];
        pipeline.channels[c].user_data_type = EXR_PIXEL_FLOAT;
        pipeline.channels[c].user_bytes_per_element = 4;
        pipeline.channels[c].user_pixel_stride = 4;
        pipeline.channels[c].user_line_stride = 4 * pipeline.channels[c].width;
    }
    assert_int_equal( exr_encoding_choose_default_routines( context, part, &pipeline ), EXR_ERR_SUCCESS );
    assert_int_equal( exr_encoding_run( context, part, &pipeline ), EXR_ERR_SUCCESS );
    exr_encoding_destroy( context, &pipeline );
}

static void add_part( exr_context_t context, const Foreign* foreign )
{
    int index;
    const exr_attr_v2f_t center = { .x = 0.0f, .y = 0.0f };
    const exr_attr_box2i_t display = { .min = { .x = 0, .y = 0 }, .max = { .x = 63, .y = 63 } };
    const exr_attr_box2i_t data = { .min = { .x = foreign->x, .y = foreign->y },
                                    .max = { .x = foreign->x + foreign->width - 1, .y = foreign->y + foreign->height - 1 } };
    const char* name = foreign->part != NULL ? foreign->part : "one";
    assert_int_equal( exr_add_part( context, name, EXR_STORAGE_SCANLINE, &index ), EXR_ERR_SUCCESS );
    assert_int_equal( exr_initialize_required_attr( context, index, &display, &data, 1.0f, &center, 1.0f,
                                                    EXR_LINEORDER_INCREASING_Y, EXR_COMPRESSION_ZIP ),
                      EXR_ERR_SUCCESS );
    for ( int c = 0; c < 6 && foreign->names[c] != NULL; ++c )
        assert_int_equal( exr_add_channel( context, index, foreign->names[c], foreign->half ? EXR_PIXEL_HALF : EXR_PIXEL_FLOAT,
                                           EXR_PERCEPTUALLY_LINEAR, 1, 1 ),
                          EXR_ERR_SUCCESS );
}

void write_foreign_exr( const char* path, const Foreign* parts, int count )
{
    exr_context_t context = NULL;
    assert_int_equal( exr_start_write( &context, path, EXR_WRITE_FILE_DIRECTLY, NULL ), EXR_ERR_SUCCESS );
    for ( int i = 0; i < count; ++i )
        add_part( context, parts + i );
    assert_int_equal( exr_write_header( context ), EXR_ERR_SUCCESS );
    for ( int i = 0; i < count; ++i )
    {
        int lines;
        assert_int_equal( exr_get_scanlines_per_chunk( context, i, &lines ), EXR_ERR_SUCCESS );
        for ( int y = 0; y < parts[i].height; y += lines )
        {
            exr_chunk_info_t chunk;
            assert_int_equal( exr_write_scanline_chunk_info( context, i, parts[i].y + y, &chunk ), EXR_ERR_SUCCESS );
            encode( context, i, parts + i, &chunk );
        }
    }
    assert_int_equal( exr_finish( &context ), EXR_ERR_SUCCESS );
}
