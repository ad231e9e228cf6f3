// --hold-all: holding all records of a group changes no picture and takes the memory that
// was announced.
#include "support/cli_run.h"

#include <jansson.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define PAPER_BYTES 1787520000.0 // 800x600, 7 frames, 2 samples, by section 4.3 of the frame-reuse paper
#define PAPER_PATHS ( 800.0 * 600.0 * 7.0 * 2.0 )

typedef struct Bytes
{
    double held, films, peak;
} Bytes;

static Bytes read_bytes( void )
{
    json_t* json = cli_read_json( "hold.json" );
    const json_t* entries = json_object_get( json, "bytes" );
    Bytes bytes = { .held = json_number_value( json_object_get( entries, "held_hit_records" ) ),
                    .films = json_number_value( json_object_get( entries, "films" ) ),
                    .peak = json_number_value( json_object_get( json, "peak_bytes" ) ) };
    json_decref( json );
    return bytes;
}

static void render( const char* scene, const char* options )
{
    cli_expect(
        cli_run( "$R render %s/%s.glb %s --float --overwrite --quiet --json hold.json", REFRAME_SCENE_FOLDER, scene, options ), 0,
        NULL );
}

// Diffuse and glossy hits; misses; mirrors and glass; blended surfaces and coats;
// cut groups at the end of a path, and more eyes than bits in a word; extra samples with the light paths of their pass.
static const struct
{
    const char *scene, *options;
} s_cases[] = {
    { "vase-room", "--group 2 --frames 20-21 --spp 10 --tile 1" },
    { "vase-room-ggx", "--group 1 --frames 46-48 --spp 6 --threads 2 --aov variance,samples" },
    { "still-life", "--group 1 --frames 1-2 --spp 6 --tile rooks16 --light-samples 2" },
    { "textured-room", "--group 1 --frames 24 --spp 6 --aov albedo,normal,motion" },
    { "vase-room-phong", "--group 1 --frames 24 --spp 6 --tile 1 --weights eq15" },
    { "vase-room-wide", "--group 16 --frames 24 --spp 33 --size 24x16 --tile 1" },
    { "still-life", "--group 3 --frames 2 --spp 14 --tile 3x3 --filter tent --aov albedo,depth" },
    { "noise-lantern", "--group 1 --frames 9 --spp 12 --tile 1 --light-paths on" },
};

#ifdef REFRAME_SANITIZED // which look at the code; pictures are the same without
#define CASES 3
#else
#define CASES ( sizeof s_cases / sizeof s_cases[0] )
#endif

static void test_pictures_are_the_same( void** state )
{
    (void)state;
    for ( size_t i = 0; i < CASES; ++i )
    {
        char options[256];
        const char* size = i == 5 ? "" : "--size 40x30 ";
        snprintf( options, sizeof options, "%s%s --memory 512M -o few.####.exr", size, s_cases[i].options );
        render( s_cases[i].scene, options );
        assert_true( read_bytes().held == 0.0 );
        snprintf( options, sizeof options, "%s%s --memory 512M --hold-all -o all.####.exr", size, s_cases[i].options );
        render( s_cases[i].scene, options );
        assert_true( read_bytes().held > 0.0 );
        cli_expect( cli_run( "for f in few.*.exr; do cmp $f all.${f#few.} || exit 1; done; rm few.* all.*" ), 0, NULL );
    }
}

// The paper's example with sides `scale` times shorter.
static Bytes render_example( int scale, const char* more )
{
    char options[256];
    snprintf( options, sizeof options,
              "--size %dx%d --frames 21-27 --group 3 --spp 14 --tile 1 --threads 1 --no-adaptive --filter box --hold-all -o "
              "paper.####.exr %s",
              800 / scale, 600 / scale, more );
    render( "vase-room", options );
    return read_bytes();
}

// All seven films, all records and everything else at once, in a quarter of the paper's bytes.
static void expect_small( Bytes bytes, double share )
{
    double paths = PAPER_PATHS * share, films = 7.0 * 800.0 * 600.0 * 32.0 * share;
    if ( bytes.held < 32.0 * paths ) // what of a diffuse hit cannot be packed: fewer, and not all were held
        fail_msg( "%.0f bytes cannot be the records of %.0f paths", bytes.held, paths );
    if ( bytes.films < films )
        fail_msg( "%.0f bytes cannot be the films of seven frames", bytes.films );
    if ( bytes.peak >= PAPER_BYTES * share / 4.0 )
        fail_msg( "all takes %.0f bytes, a quarter of the paper's are %.0f", bytes.peak, PAPER_BYTES * share / 4.0 );
}

static void test_paper_example_fits_in_its_memory( void** state )
{
    (void)state;
    // the records do not depend on the light; the budget leaves room for one batch that is not held
    Bytes bytes = render_example( 4, "--max-depth 1 --memory 27270K" );
    expect_small( bytes, 1.0 / 16.0 );
    cli_expect( cli_run( "$R plan $VASE --size 200x150 --spp 14 --filter box --quiet --json plan.json" ), 0, NULL );
    json_t* plan = cli_read_json( "plan.json" );
    double said = json_number_value( json_object_get( json_object_get( plan, "bytes_paper_example" ), "ours" ) );
    json_decref( plan );
    if ( said < 16.0 * bytes.held || said > 1.6 * 16.0 * bytes.held ) // of records as they are worked on, not packed
        fail_msg( "plan says %.0f bytes, a sixteenth of the work took %.0f packed", said, bytes.held );
    if ( getenv( "REFRAME_LONG" ) != NULL )
        expect_small( render_example( 1, "--memory 1G" ), 1.0 );
}

static const CliResult* render_held( const char* scene, const char* options, long kib )
{
    return cli_run( "$R render %s/%s.glb -o no.####.exr %s --hold-all --quiet --json hold.json --memory %ldK",
                    REFRAME_SCENE_FOLDER, scene, options, kib );
}

// Before anything is rendered the smallest budget in whole MiB is named; it works, and one less does not.
static void expect_least( const char* scene, const char* options )
{
    static const char named[] = "reframe render: a budget of 1 MiB is too small for all hit records of a group: give --memory ";
    const CliResult* result = render_held( scene, options, 1024 );
    cli_expect( result, 1, named );
    long kib = 1024 * strtol( strstr( result->err, named ) + strlen( named ), NULL, 10 );
    cli_expect( render_held( scene, options, kib - 1024 ), 1, "--hold-all" );
    assert_true( cli_run( "ls no.*" )->status != 0 );
    cli_expect( render_held( scene, options, kib ), 0, NULL );
    double peak = read_bytes().peak; // and what was said is needed
    assert_true( peak > 0.99 * 1024.0 * (double)( kib - 1024 ) && peak <= 1024.0 * (double)kib );
    cli_expect( cli_run( "rm no.*.exr" ), 0, NULL );
}

static void test_too_little_memory_is_refused( void** state )
{
    (void)state;
    expect_least( "vase-room", "--frames 24 --size 160x120 --group 3 --spp 14 --tile 1 --max-depth 1" );
    expect_least( "still-life", "--frames 1-2 --size 64x48 --group 1 --spp 6 --light-samples 2 --aov depth" );
}

int main( void )
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test( test_pictures_are_the_same ),
        cmocka_unit_test( test_paper_example_fits_in_its_memory ),
        cmocka_unit_test( test_too_little_memory_is_refused ),
    };
    return cmocka_run_group_tests( tests, cli_enter_group, cli_leave_group );
}
