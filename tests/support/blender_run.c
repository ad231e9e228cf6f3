#include "support/blender_run.h"

bool enter_with_blender( void )
{
    cli_enter();
    if ( cli_run( BLENDER "--factory-startup --python-exit-code 9 --python-expr 'import numpy' > log 2>&1" )->status == 0 )
        return true;
    cli_leave();
    printf( "skipped: there is no blender with numpy\n" );
    fflush( stdout ); // or children print it again
    return false;
}

int blender_major( void )
{
    const CliResult* done = cli_run( BLENDER "--version 2> log | sed -n 's/^Blender \\([0-9]*\\)[.].*/\\1/p' | head -1" );
    return atoi( done->out );
}

bool blender_is_4( void ) { return blender_major() >= 4; }

const CliResult* blender_make( const char* format, ... )
{
    char words[2048];
    va_list more;
    va_start( more, format );
    vsnprintf( words, sizeof words, format, more );
    va_end( more );
    const CliResult* done = cli_run( BLENDER "--factory-startup --python-exit-code 9 -P " REFRAME_SOURCE_DIR
                                             "/tests/support/blender_make.py -- %s > log 2>&1; s=$?; "
                                             "grep -v '^Fra:\\|^Saved' log; exit $s",
                                     words );
    if ( done->status != 0 )
        fail_msg( "%s: %s", words, done->out );
    return done;
}

const CliResult* blender_export( const char* scene, const char* options )
{
    return cli_run( BLENDER "%s.blend -P " BLENDER_SCRIPT "%s.glb --bake-cache cache %s", scene, scene, options );
}

const CliResult* blender_exported( const char* scene, const char* options )
{
    const CliResult* done = blender_export( scene, options );
    if ( done->status != 0 || strstr( done->err, "Traceback" ) != NULL || strstr( done->err, "not understood" ) != NULL )
        fail_msg( "%s: status %d: %s", scene, done->status, done->err );
    return done;
}

void expect_said( const char* text, const char* part )
{
    if ( strstr( text, part ) == NULL )
        fail_msg( "does not say: %s\n%s", part, text );
}

void expect_all_said( const char* text, const char* const* parts, size_t count )
{
    for ( size_t i = 0; i < count; ++i )
        expect_said( text, parts[i] );
}

const RfMaterial* find_material( const RfScene* scene, const char* name )
{
    for ( uint32_t i = 0; i < scene->material_count; ++i )
    {
        if ( strcmp( scene->materials[i].name, name ) == 0 )
            return scene->materials + i;
    }
    fail_msg( "there is no material '%s'", name );
    return NULL;
}

const RfPunctual* find_lamp( const RfScene* scene, const char* name )
{
    for ( int i = 0; i < scene->punctual_count; ++i )
    {
        if ( strcmp( scene->punctuals[i].name, name ) == 0 )
            return scene->punctuals + i;
    }
    fail_msg( "there is no lamp '%s'", name );
    return NULL;
}

// Of a block, one of `columns` by `rows`.
static double block_mean( const RfImage* image, int columns, int rows, int block )
{
    int width = image->width / columns, height = image->height / rows, x0 = block % columns * width,
        y0 = block / columns * height;
    double sum = 0.0;
    for ( int y = y0; y < y0 + height; ++y )
    {
        for ( int i = 3 * x0; i < 3 * ( x0 + width ); ++i )
            sum += (double)image->rgb[3 * (size_t)y * (size_t)image->width + (size_t)i];
    }
    return sum / ( 3.0 * width * height );
}

Difference picture_difference( const char* ours, const char* other, int columns, int rows )
{
    RfImage a = cli_read_exr( ours ), b = cli_read_exr( other );
    assert_int_equal( a.width, b.width );
    assert_int_equal( a.height, b.height );
    double whole = block_mean( &b, 1, 1, 0 );
    assert_true( whole > 0.0 );
    Difference d = { .mean = block_mean( &a, 1, 1, 0 ) / whole - 1.0 };
    for ( int i = 0; i < columns * rows; ++i )
    {
        double theirs = block_mean( &b, columns, rows, i ), off = fabs( block_mean( &a, columns, rows, i ) - theirs );
        d.blocks += off * off / ( columns * rows );
        d.worst = fmax( d.worst, ( off - 1e-3 ) / theirs );
    }
    d.blocks = sqrt( d.blocks ) / whole;
    assert_true( isfinite( d.mean ) );
    size_t count = 3 * (size_t)a.width * (size_t)a.height;
    for ( size_t i = 0; i < count; ++i )
        d.pixels += fabs( (double)a.rgb[i] - (double)b.rgb[i] ) / ( (double)count * whole );
    printf( "%s against %s: mean %+.4f, blocks %.4f, worst %.4f, pixels %.4f\n", ours, other, d.mean, d.blocks, d.worst,
            d.pixels );
    fflush( stdout ); // or children print it again
    rf_destroy_image( &a );
    rf_destroy_image( &b );
    return d;
}

double picture_mean( const char* name )
{
    RfImage image = cli_read_exr( name );
    double mean = block_mean( &image, 1, 1, 0 );
    rf_destroy_image( &image );
    return mean;
}

void expect_cycles_mean( const char* scene, double least, double most )
{
    cli_expect(
        cli_run( "$R render %s.glb -o %s.r.exr --spp 256 --group 0 --tile 1 --max-depth 26 --float --quiet", scene, scene ), 0,
        NULL );
    char ours[80], cycles[80];
    snprintf( ours, sizeof ours, "%s.r.exr", scene );
    snprintf( cycles, sizeof cycles, "%s-1.exr", scene );
    double ratio = 1.0 + picture_difference( ours, cycles, 1, 1 ).mean;
    if ( !( ratio >= least && ratio <= most ) )
        fail_msg( "%s: the mean is %.4f of Cycles'", scene, ratio );
}
