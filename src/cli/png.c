// reframe png: an EXR file as PNG, to look at.

#include "cli/commands.h"
#include "cli/options/options.h"
#include "cli/messages.h"
#include "reframe/image.h"

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
                                        .summary = "Writes an EXR file as 8-bit PNG with the sRGB curve.",
                                        .files = s_files,
                                        .file_count = 2,
                                        .writes_last = true,
                                        .options = s_options,
                                        .option_count = 1 };

static RfResult convert( const char* from, const char* to, RfError* error )
{
    RfImage image = { 0 };
    RfResult result = rf_read_exr( from, &image, error );
    if ( result != RF_OK )
        return result;
    result = rf_write_png( to, &image, (float)s_exposure, error );
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
