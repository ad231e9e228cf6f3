// reframe reconstruct as a user has it: layers by name, separate files, halves, sequences, and what it refuses.
#include "base/random.h"
#include "image/exr.h"
#include "support/cli_run.h"
#include "support/test.h"

#define WIDTH 12
#define HEIGHT 9
#define PIXELS ( WIDTH * HEIGHT )

typedef struct Layers
{
    float primal[3 * PIXELS], dx[3 * PIXELS], dy[3 * PIXELS], variance[3 * PIXELS];
} Layers;

static float truth( int x, int y, int c ) { return 0.1f * (float)( c + 1 ) + ( x > 5 ? 0.5f : 0.01f * (float)( x * y ) ); }

// Primal and gradients of the truth plus noise of this size.
static Layers make( float noise, uint32_t seed )
{
    Layers l;
    for ( int i = 0; i < PIXELS; ++i )
    {
        RfRandomKey key = rf_pixel_key( rf_pass_key( seed, 0, 0, 0 ), (uint32_t)i );
        for ( int c = 0; c < 3; ++c )
        {
            int x = i % WIDTH, y = i / WIDTH;
            uint32_t k = 3 * (uint32_t)c;
            l.primal[3 * i + c] = truth( x, y, c ) + noise * ( rf_random( key, k ) - 0.5f );
            l.dx[3 * i + c] = truth( x + 1, y, c ) - truth( x, y, c ) + 0.3f * noise * ( rf_random( key, k + 1 ) - 0.5f );
            l.dy[3 * i + c] = truth( x, y + 1, c ) - truth( x, y, c ) + 0.3f * noise * ( rf_random( key, k + 2 ) - 0.5f );
            l.variance[3 * i + c] = ( c == 0 ? 1.0f : 0.1f ) * ( 0.5f + rf_random( key, 9 + (uint32_t)c ) );
        }
    }
    return l;
}

// Names of layers in a file: colour "" are R, G and B.
typedef struct Names
{
    const char *primal, *dx, *dy, *variance;
} Names;

static const Names s_usual = { "primal", "dx", "dy", NULL }, s_weighted = { "primal", "dx", "dy", "" };

typedef struct File
{
    RfExrChannel channels[32];
    char names[32][48];
    int count;
} File;

static void add( File* file, const char* prefix, const char* layer, const char* channel, const float* values )
{
    char* name = file->names[file->count];
    snprintf( name, sizeof file->names[0], "%s%s.%s", prefix, layer, channel );
    file->channels[file->count++] = ( RfExrChannel ){ .name = name, .values = values, .stride = 3 };
}

static void add_layers( File* file, const char* prefix, const Names* names, const Layers* l )
{
    const char *layers[3] = { names->primal, names->dx, names->dy }, *channels[3] = { "R", "G", "B" };
    const float* values[3] = { l->primal, l->dx, l->dy };
    for ( int k = 0; k < 3; ++k )
    {
        for ( int c = 0; c < 3 && layers[k] != NULL; ++c )
            add( file, prefix, layers[k], channels[c], values[k] + c );
        if ( names->variance != NULL )
            add( file, prefix, layers[k], "variance", l->variance + k );
    }
}

// Writes the layers, with `colour` as R, G and B.
static void write_file( const char* name, const File* file, const float* colour )
{
    RfError error;
    RfImage image = { WIDTH, HEIGHT, (float*)(uintptr_t)colour };
    RfExrOptions options = rf_default_exr_options();
    options.half = false;
    options.x = 5;
    options.y = -3;
    options.fps_numerator = 24;
    options.fps_denominator = 1;
    options.channels = file->channels;
    options.channel_count = file->count;
    if ( rf_write_exr( cli_path( name ), &image, &options, &error ) != RF_OK )
        fail_msg( "%s", error.text );
}

static void write_layers( const char* name, const Names* names, const Layers* l )
{
    static const float black[3 * PIXELS];
    File file = { .count = 0 };
    add_layers( &file, "", names, l );
    write_file( name, &file, names->primal != NULL ? black : l->primal );
}

static void read_result( const char* name, float* rgb )
{
    AUTO_IMAGE image;
    RfExrWindow window;
    RfError error;
    if ( rf_read_exr_layer( cli_path( name ), NULL, &image, &window, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    assert_true( window.x == 5 && window.y == -3 && window.width == WIDTH && window.height == HEIGHT );
    memcpy( rgb, image.rgb, 3 * PIXELS * sizeof *rgb );
}

static double error_of( const float* rgb )
{
    double sum = 0.0;
    for ( int i = 0; i < 3 * PIXELS; ++i )
    {
        double e = (double)( rgb[i] - truth( i / 3 % WIDTH, i / 3 / WIDTH, i % 3 ) );
        sum += e * e / ( 3 * PIXELS );
    }
    return sqrt( sum );
}

static double error_of_file( const char* name )
{
    float rgb[3 * PIXELS];
    read_result( name, rgb );
    return error_of( rgb );
}

// The header and the JSON say this of the result.
static void check_said( const char* name, const char* json_name, const char* header, const char* method, bool biased )
{
    cli_expect_exr_text( name, "reframe/reconstruction", header );
    json_auto_t* json = cli_read_json( json_name );
    assert_string_equal( json_string_value( json_object_get( json, "method" ) ), method );
    assert_true( json_is_true( json_object_get( json, "biased" ) ) == biased );
    assert_true( json_is_true( json_object_get( json, "converged" ) ) );
    assert_true( json_number_value( json_object_get( json, "residual" ) ) < 1e-5 );
}

TEST( test_exact_layers_give_the_image )
{
    Layers exact = make( 0.0f, 1 );
    const Names of_colour = { NULL, "dx", "dy", NULL }, others = { "noisy", "gx", "g.y", NULL };
    write_layers( "a.exr", &of_colour, &exact );
    write_layers( "b.exr", &s_usual, &exact );
    write_layers( "c.exr", &others, &exact );
    cli_expect( cli_run( "$R reconstruct a.exr -o out.exr --json out.json --quiet" ), 0, NULL );
    assert_true( error_of_file( "out.exr" ) < 1e-6 );
    check_said( "out.exr", "out.json", "l2, alpha 0.2: unbiased", "l2", false );
    AUTO_BY( rf_destroy_exr_header ) RfExrHeader header;
    assert_int_equal( rf_read_exr_header( cli_path( "out.exr" ), NULL, &header, NULL ), RF_OK );
    assert_true( header.fps_numerator == 24 && header.fps_denominator == 1 );
    cli_expect( cli_run( "$R reconstruct b.exr -o out2.exr" ), 0, NULL );
    assert_true( error_of_file( "out2.exr" ) < 1e-6 );
    cli_expect( cli_run( "$R reconstruct c.exr -o out3.exr --primal noisy --dx gx --dy g.y.R,g.y.G,g.y.B" ), 0, NULL );
    assert_true( error_of_file( "out3.exr" ) < 1e-6 );
}

TEST( test_gradients_of_another_program_in_files_of_their_own )
{
    Layers exact = make( 0.0f, 1 );
    File none = { .count = 0 };
    write_file( "p.exr", &none, exact.primal );
    write_file( "p-dx.exr", &none, exact.dx );
    write_file( "p-dy.exr", &none, exact.dy );
    cli_expect( cli_run( "$R reconstruct p.exr --dx-from p-dx.exr --dy-from p-dy.exr -o out.exr" ), 0, NULL );
    assert_true( error_of_file( "out.exr" ) < 1e-6 );
    cli_expect( cli_run( "$R reconstruct p.exr --dx-from p-dx.exr -o none.exr" ), 1, "has no layer dy" );
    cli_expect( cli_run( "$R reconstruct p.exr p.exr --dx-from p-dx.exr -o none.exr" ), 2, "--dx-from: gradients of one file" );
    assert_false( cli_exists( "none.exr" ) );
}

TEST( test_halves_are_weighted_by_each_other )
{
    Layers halves[2] = { make( 0.4f, 1 ), make( 0.4f, 2 ) };
    const Names plain = { "primal", "dx", "dy", NULL };
    File both = { .count = 0 };
    write_layers( "even.exr", &s_weighted, halves );
    write_layers( "odd.exr", &s_weighted, halves + 1 );
    write_layers( "plain.exr", &plain, halves );
    add_layers( &both, "even.", &s_weighted, halves );
    add_layers( &both, "odd.", &s_weighted, halves + 1 );
    write_file( "both.exr", &both, halves[0].primal );
    cli_expect( cli_run( "$R reconstruct even.exr odd.exr -o two.exr --json two.json" ), 0, NULL );
    cli_expect( cli_run( "$R reconstruct both.exr -o one.exr" ), 0, NULL );
    check_said( "two.exr", "two.json", "weighted, weights from the other half: unbiased", "weighted", false );
    float one[3 * PIXELS], two[3 * PIXELS];
    read_result( "one.exr", one );
    read_result( "two.exr", two );
    assert_memory_equal( one, two, sizeof one );
    cli_expect( cli_run( "$R reconstruct both.exr --method l2 -o l2.exr" ), 0, NULL );
    assert_true( error_of( two ) < 0.7 * error_of( halves[0].primal ) &&
                 error_of_file( "l2.exr" ) < 0.7 * error_of( halves[0].primal ) );
    // weights of the data's own half, where the user insists
    const CliResult* run = cli_run( "$R reconstruct even.exr --method weighted -o own.exr --json own.json" );
    cli_expect( run, 0, "warning: the weights come from the data that they weigh, which biases the image" );
    assert_non_null( strstr( run->out, "weights from the same data: biased" ) );
    check_said( "own.exr", "own.json", "weighted, weights from the same data: biased", "weighted", true );
    cli_expect( cli_run( "$R reconstruct plain.exr --method weighted -o no.exr" ), 1, "name its variances by --variance A,X,Y" );
    cli_expect( cli_run( "$R reconstruct even.exr plain.exr --method weighted -o no.exr" ), 1, "has no channel primal.variance" );
    cli_expect( cli_run( "$R reconstruct both.exr --method weighted --alpha 1 -o no.exr" ), 2,
                "--alpha: needs --method l2 or l1" );
    cli_expect( cli_run( "$R reconstruct plain.exr --variance a,b,c -o no.exr" ), 1, "has no layer a,b,c" );
}

TEST( test_l1_says_that_it_is_biased )
{
    Layers noisy = make( 0.1f, 3 );
    noisy.primal[150] = 1000.0f;
    write_layers( "a.exr", &s_usual, &noisy );
    const CliResult* run = cli_run( "$R reconstruct a.exr --method l1 --alpha 0.5 -o out.exr --json out.json" );
    cli_expect( run, 0, NULL );
    assert_non_null( strstr( run->out, "1 frame in out.exr: l1, alpha 0.5: biased;" ) );
    check_said( "out.exr", "out.json", "l1, alpha 0.5: biased", "l1", true );
    assert_true( error_of_file( "out.exr" ) < 0.1 );
}

TEST( test_sequences_keep_their_numbers )
{
    Layers exact = make( 0.0f, 1 );
    cli_run( "mkdir shot" );
    const int numbers[3] = { 3, 4, 6 };
    for ( int i = 0; i < 3; ++i )
    {
        char name[64];
        snprintf( name, sizeof name, "shot/f.%04d.exr", numbers[i] );
        write_layers( name, &s_usual, &exact );
    }
    const CliResult* run = cli_run( "$R reconstruct shot -o out.##.exr --json out.json" );
    cli_expect( run, 0, "warning: shot/f.####.exr: lacks frame 5" );
    assert_non_null( strstr( run->out, "3 frames in out.##.exr: l2" ) );
    assert_true( cli_exists( "out.03.exr" ) && cli_exists( "out.06.exr" ) && error_of_file( "out.04.exr" ) < 1e-6 );
    json_auto_t* json = cli_read_json( "out.json" );
    const json_t* frames = json_object_get( json, "frames" );
    assert_int_equal( json_array_size( frames ), 3 );
    assert_int_equal( json_integer_value( json_object_get( json_array_get( frames, 2 ), "frame" ) ), 6 );
    cli_expect( cli_run( "$R reconstruct shot/f.####.exr --frames 4 -o one.##.exr" ), 0, NULL );
    assert_true( cli_exists( "one.04.exr" ) && !cli_exists( "one.03.exr" ) );
    cli_expect( cli_run( "$R reconstruct shot/f.####.exr --frames 5 -o one.##.exr" ), 1, "frame 5 is missing" );
    cli_expect( cli_run( "$R reconstruct shot -o one.exr" ), 2, "-o: one.exr: has no ####" );
    cli_expect( cli_run( "$R reconstruct shot -o shot/f.####.exr" ), 2, "is also the input" );
    cli_expect( cli_run( "$R reconstruct shot shot/f.0003.exr -o o.#.exr" ), 2,
                "shot is a sequence, but shot/f.0003.exr is a file" );
}

TEST( test_what_cannot_be_read_leaves_no_file )
{
    Layers layers = make( 0.0f, 1 );
    const Names no_dy = { "primal", "dx", NULL, NULL };
    write_layers( "no-dy.exr", &no_dy, &layers );
    layers.dx[3 * 14 + 1] = NAN;
    write_layers( "nan.exr", &s_usual, &layers );
    cli_write( "out.exr", "kept", 4 );
    int files = cli_count_files( "", "." );
    cli_expect( cli_run( "$R reconstruct no-dy.exr -o out.exr" ), 1, "no-dy.exr: has no layer dy; it has " );
    cli_expect( cli_run( "$R reconstruct no-dy.exr -o out.exr" ), 1, ": name it by --dy" );
    cli_expect( cli_run( "$R reconstruct nan.exr -o out.exr" ), 1, "nan.exr: dx: NaN at pixel (2, 1)" );
    cli_expect( cli_run( "$R reconstruct none.exr -o out.exr" ), 1, "none.exr" );
    cli_expect( cli_run( "$R reconstruct nan.exr" ), 2, "-o FILE is missing" );
    cli_expect( cli_run( "$R reconstruct nan.exr -o nan.exr" ), 2, "would overwrite an input" );
    cli_expect( cli_run( "$R reconstruct nan.exr -o out.png" ), 2, "ends as a file of another kind" );
    cli_expect( cli_run( "$R reconstruct nan.exr -o out.exr --alpha 0" ), 2, "--alpha: expected a number from 0.0001" );
    assert_int_equal( cli_count_files( "", "." ), files );
    size_t size;
    AUTO_FREE char* kept = cli_read( "out.exr", &size );
    assert_true( size == 4 && memcmp( kept, "kept", 4 ) == 0 );
}

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )
