// The option table: every type, every way to get one wrong, and the help text.
#include "support/test.h"
#include "cli/messages.h"
#include "cli/options/options.h"

typedef struct Values
{
    int spp, group, weights, adaptive;
    uint64_t seed;
    double exposure, noise, time;
    RfSize size;
    size_t memory;
    RfFps fps;
    const char* json;
    bool resume, half, spp_given;
} Values;

static const char* const weight_names[] = { "exact", "eq15", "unweighted", NULL };
static const char* const adaptive_names[] = { "auto", "on", "off", NULL };
static const char* const file_names[] = { "SCENE" };
static Values s_values;
static const char* s_file;
static bool s_help;

static const RfOption s_options[] = {
    { .name = "spp",
      .type = RF_OPTION_INT,
      .value = &s_values.spp,
      .min = 1,
      .max = 1048576,
      .meta = "S",
      .default_text = "28",
      .help = "samples",
      .given = &s_values.spp_given },
    { .name = "group",
      .type = RF_OPTION_INT,
      .value = &s_values.group,
      .max = 64,
      .keyword = "auto",
      .keyword_value = -1,
      .meta = "N|auto",
      .help = "half-width" },
    { .name = "seed", .type = RF_OPTION_UINT64, .value = &s_values.seed, .meta = "S", .help = "seed" },
    { .name = "exposure",
      .type = RF_OPTION_REAL,
      .value = &s_values.exposure,
      .min = -32,
      .max = 32,
      .meta = "E",
      .help = "stops" },
    { .name = "noise", .type = RF_OPTION_NOISE, .value = &s_values.noise, .max = 100, .meta = "E", .help = "relMSE" },
    { .name = "time", .type = RF_OPTION_TIME, .value = &s_values.time, .max = 1e6, .meta = "T", .help = "seconds" },
    { .name = "size", .type = RF_OPTION_SIZE, .value = &s_values.size, .min = 1, .max = 32768, .meta = "WxH", .help = "pixels" },
    { .name = "memory", .type = RF_OPTION_MEMORY, .value = &s_values.memory, .min = 1048576, .meta = "SIZE", .help = "budget" },
    { .name = "fps", .type = RF_OPTION_FPS, .value = &s_values.fps, .meta = "R", .help = "rate" },
    { .name = "weights", .type = RF_OPTION_CHOICE, .value = &s_values.weights, .choices = weight_names, .help = "weights" },
    { .name = "adaptive",
      .type = RF_OPTION_CHOICE,
      .value = &s_values.adaptive,
      .choices = adaptive_names,
      .bare = "on",
      .negated = "off",
      .help = "more samples" },
    { .name = "json", .letter = 'j', .type = RF_OPTION_STRING, .value = &s_values.json, .meta = "FILE", .help = "result" },
    { .name = "resume", .type = RF_OPTION_BOOL, .value = &s_values.resume, .help = "go on" },
    { .name = "half", .type = RF_OPTION_BOOL, .value = &s_values.half, .help = "half floats" },
};

static const RfCommandTable s_table = { .command = "render",
                                        .summary = "Renders.",
                                        .files = file_names,
                                        .file_count = 1,
                                        .options = s_options,
                                        .option_count = sizeof s_options / sizeof s_options[0] };

// Splits `line` at blanks and parses it; the text lives until the next call.
static RfResult parse( const char* line, RfError* error )
{
    static char copy[512];
    static char* argv[32];
    int argc = 0;
    snprintf( copy, sizeof copy, "render %s", line );
    for ( char* word = strtok( copy, " " ); word != NULL && argc < 32; word = strtok( NULL, " " ) )
        argv[argc++] = word;
    s_values = ( Values ){ .spp = 28, .half = true };
    s_file = NULL;
    return rf_parse_options( &s_table, argc, argv, &s_file, &s_help, error );
}

static void expect_ok( const char* line )
{
    RfError error = { .code = RF_OK };
    if ( parse( line, &error ) != RF_OK )
        fail_msg( "'%s': %s", line, error.text );
}

static void expect_error( const char* line, const char* text )
{
    RfError error = { .code = RF_OK };
    if ( parse( line, &error ) != RF_ERROR_USAGE )
        fail_msg( "'%s' was taken", line );
    assert_string_equal( error.text, text );
}

TEST( test_every_type_in_any_order )
{
    expect_ok( "--spp 7 --group=3 a.glb --seed 18446744073709551615 --exposure -1.5 --size 17x9 --memory 1.5G "
               "--fps=24000/1001 --weights unweighted -j - --resume --no-half" );
    assert_string_equal( s_file, "a.glb" );
    assert_int_equal( s_values.spp, 7 );
    assert_true( s_values.spp_given );
    assert_int_equal( s_values.group, 3 );
    assert_true( s_values.seed == UINT64_MAX );
    assert_true( s_values.exposure == -1.5 );
    assert_int_equal( s_values.size.width, 17 );
    assert_int_equal( s_values.size.height, 9 );
    assert_true( s_values.memory == (size_t)3 << 29 );
    assert_int_equal( s_values.fps.numerator, 24000 );
    assert_int_equal( s_values.fps.denominator, 1001 );
    assert_int_equal( s_values.weights, 2 );
    assert_string_equal( s_values.json, "-" );
    assert_true( s_values.resume );
    assert_false( s_values.half );
}

TEST( test_the_last_of_an_option_holds )
{
    expect_ok( "a.glb --spp 3 --json a,b --resume -j c --spp=4 --no-resume --size 720p --size 8x4" );
    assert_int_equal( s_values.spp, 4 );
    assert_string_equal( s_values.json, "c" ); // a list as a whole
    assert_false( s_values.resume );
    assert_int_equal( s_values.size.width, 8 );
    expect_error( "a --spp 0 --spp 4", "--spp: expected a whole number from 1 to 1048576, got '0'" );
}

TEST( test_defaults_and_keywords )
{
    expect_ok( "a.glb" );
    assert_int_equal( s_values.spp, 28 );
    assert_false( s_values.spp_given );
    assert_true( s_values.half );
    expect_ok( "--group auto a.glb --fps 25" );
    assert_int_equal( s_values.group, -1 );
    assert_int_equal( s_values.fps.numerator, 25 );
    assert_int_equal( s_values.fps.denominator, 1 );
    static const struct
    {
        const char* text;
        int whole;
    } rates[] = { { "23.976", 24 }, { "23.98", 24 }, { "23.9760239760", 24 }, { "29.97", 30 },  { "29.970", 30 },
                  { "47.952", 48 }, { "59.94", 60 }, { "119.88", 120 },       { "239.76", 240 } };
    for ( size_t i = 0; i < sizeof rates / sizeof rates[0]; ++i )
    {
        char line[64];
        snprintf( line, sizeof line, "a.glb --fps %s", rates[i].text );
        expect_ok( line );
        assert_int_equal( s_values.fps.numerator, 1000 * rates[i].whole );
        assert_int_equal( s_values.fps.denominator, 1001 );
    }
    expect_ok( "--memory 512m -- --odd-name.glb" );
    assert_string_equal( s_file, "--odd-name.glb" );
    assert_true( s_values.memory == (size_t)512 << 20 );
    expect_ok( "--help --nonsense" );
    assert_true( s_help );
}

TEST( test_wrong_numbers_are_refused )
{
    static const char* const wrong[] = { "0", "-1", "1048577", "7x", "0x7", "7.0", "+7", "1e3", "99999999999999999999" };
    for ( size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i )
    {
        char line[128], text[256];
        snprintf( line, sizeof line, "a.glb --spp %s", wrong[i] );
        snprintf( text, sizeof text, "--spp: expected a whole number from 1 to 1048576, got '%s'", wrong[i] );
        expect_error( line, text );
    }
    expect_error( "a --spp=", "--spp: expected a whole number from 1 to 1048576, got ''" );
    expect_error( "a --group some", "--group: expected a whole number from 0 to 64 or auto, got 'some'" );
    expect_error( "a --seed -1", "--seed: expected a whole number from 0 to 18446744073709551615, got '-1'" );
    expect_error( "a --seed 18446744073709551616",
                  "--seed: expected a whole number from 0 to 18446744073709551615, got '18446744073709551616'" );
    expect_error( "a --exposure nan", "--exposure: expected a number from -32 to 32, got 'nan'" );
    expect_error( "a --exposure 33", "--exposure: expected a number from -32 to 32, got '33'" );
    expect_error( "a --exposure 1.5.5", "--exposure: expected a number from -32 to 32, got '1.5.5'" );
}

TEST( test_wrong_words_are_refused )
{
    static const char* const sizes[] = {
        "960", "960x", "x540", "0x5", "960x540x3", "32769x1", "1X1", "1081p", "1080P", "4kx", "p"
    };
    for ( size_t i = 0; i < sizeof sizes / sizeof sizes[0]; ++i )
    {
        char line[128], text[256];
        snprintf( line, sizeof line, "a.glb --size=%s", sizes[i] );
        snprintf( text, sizeof text,
                  "--size: expected WIDTHxHEIGHT, such as 960x540, each from 1 to 32768, or 720p, 1080p, 1440p, "
                  "2160p or 4k, got '%s'",
                  sizes[i] );
        expect_error( line, text );
    }
    static const char* const memories[] = { "4Q", "G", "1GG", "0", "-4G", "1e99G", "4 G" };
    for ( size_t i = 0; i + 1 < sizeof memories / sizeof memories[0]; ++i )
    {
        char line[128], text[256];
        snprintf( line, sizeof line, "a.glb --memory=%s", memories[i] );
        snprintf( text, sizeof text, "--memory: expected a size such as 512M, 4G or 1.5G, at least 1048576 bytes, got '%s'",
                  memories[i] );
        expect_error( line, text );
    }
    static const char* const rates[] = {
        "24/0", "0", "24.5", "23.97", "29.98", "29.97x", "29.", ".5", "1e3", "24/", "/1", "25.00"
    };
    for ( size_t i = 0; i < sizeof rates / sizeof rates[0]; ++i )
    {
        char line[64], wanted[128];
        snprintf( line, sizeof line, "a --fps %s", rates[i] );
        snprintf( wanted, sizeof wanted, "--fps: expected frames per second, such as 24, 29.97 or 30000/1001, got '%s'",
                  rates[i] );
        expect_error( line, wanted );
    }
    expect_error( "a --weights Exact", "--weights: expected exact, eq15 or unweighted, got 'Exact'" );
}

TEST( test_wrong_shape_is_refused )
{
    expect_error( "a --sppp 3", "--sppp: no such option, did you mean --spp?" );
    expect_error( "a --weigth=3", "--weigth: no such option, did you mean --weights?" );
    expect_error( "a --frobnicate", "--frobnicate: no such option, see reframe render --help" );
    expect_error( "a -x", "-x: no such option, see reframe render --help" );
    expect_error( "a --no-spp 3", "--no-spp: no such option, did you mean --spp?" );
    expect_error( "a --spp", "--spp: its value is missing" );
    expect_error( "--json --resume a", "--json: its value is missing" );
    expect_error( "a --json=", "--json: expected a value that is not empty, got ''" );
    expect_error( "a --resume=1", "--resume: takes no value, got '1'" );
    expect_error( "a b", "'b' is one file too many, see reframe render --help" );
    expect_error( "--spp 3", "SCENE is missing, see reframe render --help" );
}

// Sizes by their names, times with units, percent.
TEST( test_units_that_users_type )
{
    static const struct
    {
        const char* text;
        int width, height;
    } sizes[] = { { "720p", 1280, 720 },   { "1080p", 1920, 1080 }, { "1440p", 2560, 1440 },
                  { "2160p", 3840, 2160 }, { "4k", 3840, 2160 },    { "16x9", 16, 9 } };
    static const struct
    {
        const char* text;
        double seconds;
    } times[] = { { "20", 20.0 },     { "20s", 20.0 },    { "5m", 300.0 },  { "1h30m", 5400.0 }, { "1h0m2.5s", 3602.5 },
                  { "1.5h", 5400.0 }, { "2h3s", 7203.0 }, { "1e2", 100.0 }, { "0", 0.0 } };
    static const char* const wrong[] = { "20x", "s", "5m5m", "3s2m", "1h30", "-5s", "20 s", "5M", "1h-3m", "nan", "300h", "" };
    static const char* const not_percent[] = { "1%%", "%", "1 %", "1%x", "-1%", "578%" };
    for ( size_t i = 0; i < sizeof sizes / sizeof sizes[0]; ++i )
    {
        char line[64];
        snprintf( line, sizeof line, "a --size %s", sizes[i].text );
        expect_ok( line );
        assert_true( s_values.size.width == sizes[i].width && s_values.size.height == sizes[i].height );
    }
    for ( size_t i = 0; i < sizeof times / sizeof times[0]; ++i )
    {
        char line[64];
        snprintf( line, sizeof line, "a --time=%s", times[i].text );
        expect_ok( line );
        assert_true( s_values.time == times[i].seconds );
    }
    for ( size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i )
    {
        char text[128];
        RfOption option = s_options[5];
        RfError error;
        assert_int_equal( rf_parse_option_value( &option, wrong[i], &error ), RF_ERROR_USAGE );
        snprintf( text, sizeof text, "--time: expected seconds from 0 to 1e+06, or a time such as 20s, 5m or 1h30m, got '%s'",
                  wrong[i] );
        assert_string_equal( error.text, text );
    }
    expect_ok( "a --noise 10%" ); // √(relMSE / 3)
    assert_true( fabs( s_values.noise - 0.03 ) < 1e-15 && fabs( rf_noise_percent( s_values.noise ) - 10.0 ) < 1e-12 );
    expect_ok( "a --noise 577%" );
    expect_ok( "a --noise 0.25" );
    assert_true( s_values.noise == 0.25 );
    for ( size_t i = 0; i < sizeof not_percent / sizeof not_percent[0]; ++i )
    {
        RfOption option = s_options[4];
        assert_int_equal( rf_parse_option_value( &option, not_percent[i], NULL ), RF_ERROR_USAGE );
    }
}

// What other programs call an option.
TEST( test_synonyms_are_suggested )
{
    expect_error( "a --samples 3", "--samples: no such option, did you mean --spp?" );
    expect_error( "a --resolution=3x3", "--resolution: no such option, did you mean --size?" );
    expect_error( "a --continue", "--continue: no such option, did you mean --resume?" );
    expect_error( "a --bounces 3", "--bounces: no such option, see reframe render --help" ); // none in this table
}

// A choice with a bare and a negated form: what follows is its value only if it is one of the choices.
TEST( test_value_may_be_left_out )
{
    static const struct
    {
        const char* line;
        int choice;
    } cases[] = { { "a.glb", 0 },
                  { "a.glb --adaptive", 1 },
                  { "--adaptive a.glb", 1 },
                  { "--adaptive --resume a.glb", 1 },
                  { "--adaptive=auto a.glb", 0 },
                  { "--adaptive auto a.glb", 0 },
                  { "a.glb --adaptive on", 1 },
                  { "--adaptive off a.glb", 2 },
                  { "--adaptive -- a.glb", 1 },
                  { "--no-adaptive a.glb", 2 } };
    for ( size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i )
    {
        expect_ok( cases[i].line );
        assert_int_equal( s_values.adaptive, cases[i].choice );
        assert_string_equal( s_file, "a.glb" );
    }
    expect_ok( "a --adaptive=on --no-adaptive" );
    assert_int_equal( s_values.adaptive, 2 );
    expect_ok( "--no-adaptive off" ); // a file of that name
    assert_string_equal( s_file, "off" );
    expect_error( "a --adaptive=yes", "--adaptive: expected auto, on or off, got 'yes'" );
    expect_error( "a --adaptive=", "--adaptive: expected auto, on or off, got ''" );
    expect_error( "a --no-adaptive=on", "--no-adaptive: takes no value, got 'on'" );
    expect_error( "a --adaptive on off", "'off' is one file too many, see reframe render --help" );
}

// The last file may be more than one where the table says so.
TEST( test_last_file_may_be_many )
{
    static const char* const names[] = { "A", "DIR" };
    int total = 0;
    const RfCommandTable table = {
        .command = "many", .summary = "Many.", .files = names, .file_count = 2, .file_max = 4, .file_total = &total
    };
    const char* files[4];
    bool help;
    RfError error;
    char* arguments[] = { "many", "a", "b", "c", "d", "e" };
    for ( int count = 2; count <= 4; ++count )
    {
        assert_int_equal( rf_parse_options( &table, 1 + count, arguments, files, &help, &error ), RF_OK );
        assert_int_equal( total, count );
        assert_string_equal( files[count - 1], arguments[count] );
    }
    assert_int_equal( rf_parse_options( &table, 2, arguments, files, &help, &error ), RF_ERROR_USAGE );
    assert_string_equal( error.text, "DIR is missing, see reframe many --help" );
    assert_int_equal( rf_parse_options( &table, 6, arguments, files, &help, &error ), RF_ERROR_USAGE );
    assert_string_equal( error.text, "'e' is one file too many, see reframe many --help" );
    arguments[3] = "";
    assert_int_equal( rf_parse_options( &table, 4, arguments, files, &help, &error ), RF_ERROR_USAGE );
    assert_string_equal( error.text, "DIR: the name is empty" );
    char text[1024];
    FILE* file = tmpfile();
    assert_non_null( file );
    rf_print_help( &table, file );
    rewind( file );
    text[fread( text, 1, sizeof text - 1, file )] = '\0';
    fclose( file );
    assert_non_null( strstr( text, "usage: reframe many [OPTIONS] A DIR...\n" ) );
}

TEST( test_help_names_every_option )
{
    char text[8192];
    FILE* file = tmpfile();
    assert_non_null( file );
    rf_print_help( &s_table, file );
    rewind( file );
    text[fread( text, 1, sizeof text - 1, file )] = '\0';
    fclose( file );
    assert_non_null( strstr( text, "usage: reframe render [OPTIONS] SCENE\nRenders.\n" ) );
    assert_non_null( strstr( text, "  --spp S                         samples (default: 28)\n" ) );
    assert_non_null( strstr( text, "--weights exact|eq15|unweighted" ) );
    assert_non_null( strstr( text, "  --[no-]resume                   go on\n" ) );
    assert_non_null( strstr( text, "  --[no-]adaptive [auto|on|off]   more samples (default: " ) );
    assert_non_null( strstr( text, "  -j, --json FILE" ) );
    assert_non_null( strstr( text, "  --group N|auto" ) );
}
