// reframe png: an EXR file as PNG, to look at.

#include "cli/commands.h"
#include "cli/options/options.h"
#include "cli/messages.h"
#include "reframe/image.h"

#include <stdlib.h>

static double s_exposure;
static const char* const s_files[] = { "IN.exr", "OUT.png" };
static const RfOption s_options[] = {
    { .name = "exposure",
      .type = RF_OPTION_REAL,
      .value = &s_exposure,
      .min = -32,
      .max = 32,
      .meta = "E",
      .default_text = "0",
      .help = "brighter by E stops: each doubles the light" },
};
static const RfCommandTable s_table = { .command = "png",
                                        .summary =
                                            "Writes an EXR file as 8-bit PNG with the sRGB curve, and its alpha if it has one.",
                                        .files = s_files,
                                        .file_count = 2,
                                        .writes_last = true,
                                        .options = s_options,
                                        .option_count = 1 };

// The channel A of a file; NULL where it has none of the size of its colour.
static float* read_alpha( const char* path, const RfImage* image )
{
    static const char* const s_name = "A";
    RfExrWindow window;
    float* alpha = NULL;
    if ( rf_read_exr_channels( path, &s_name, 1, &window, &alpha, NULL ) != RF_OK )
        return NULL;
    if ( window.width == image->width && window.height == image->height )
        return alpha;
    free( alpha );
    return NULL;
}

static RfResult convert( const char* from, const char* to, RfError* error )
{
    RfImage image = { 0 };
    RfResult result = rf_read_exr( from, &image, error );
    if ( result != RF_OK )
        return result;
    float* alpha = read_alpha( from, &image );
    result = rf_write_png_alpha( to, &image, alpha, (float)s_exposure, error );
    free( alpha );
    rf_destroy_image( &image );
    return result;
}

int rf_command_png( int argc, char** argv )
{
    const char* files[2];
    bool help;
    RfError error;
    RfResult result = rf_parse_options( &s_table, argc, argv, files, &help, &error );
    if ( result == RF_OK && help )
    {
        rf_print_help( &s_table, stdout );
        result = rf_flush_output( &error );
    }
    else if ( result == RF_OK )
        result = convert( files[0], files[1], &error );
    return result == RF_OK ? 0 : rf_report_error( "png", &error );
}
