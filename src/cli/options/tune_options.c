#include "cli/options/tune_options.h"

#include "base/plain_text.h"
#include "cli/options/shot_options.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

#define BUDGET 60.0 // seconds

static const char* const s_goals[] = { "noise", "flicker", NULL }; // in the order of RfTuneGoal
static const char* const s_files[] = { "SCENE" };
static RfTuneOptions s_parsed; // the table points here
static const char* s_scene;

static const RfOption s_options[] = {
    { .name = "budget",
      .type = RF_OPTION_TIME,
      .value = &s_parsed.budget,
      .min = 1.0,
      .max = 1e6,
      .meta = "T",
      .default_text = "60",
      .help = "seconds that it may take, or 5m; more make the choice surer" },
    { .name = "goal",
      .type = RF_OPTION_CHOICE,
      .value = &s_parsed.goal,
      .choices = s_goals,
      .default_text = "noise",
      .help = "what is to be least at equal CPU time: relMSE, or F1 of neighbouring frames" },
    { .name = "svg",
      .writes = ".svg",
      .type = RF_OPTION_STRING,
      .value = &s_parsed.svg,
      .meta = "FILE",
      .help = "a plot: memory across, efficiency up, a line for each tile" },
    RF_PATH_OPTIONS( s_parsed.render, "frames that are to be rendered: settings are tried there, and their cost is counted" ),
    RF_LENS_OPTIONS( s_parsed.render, true ),
    RF_EFFECT_OPTIONS( s_parsed.render, true ),
    RF_SPP_OPTION( s_parsed.render ),
    RF_ESTIMATOR_OPTION( s_parsed.render ),
    RF_LIGHT_OPTIONS( s_parsed.render ),
    RF_FILTER_OPTIONS( s_parsed.render, true ),
    RF_SEED_OPTION( s_parsed.render ),
    RF_MACHINE_OPTIONS( s_parsed.render, "threads, each of which tries a setting" ),
    RF_AOV_OPTION( s_parsed.render, "further channels, which need memory:" ),
    RF_RESULT_OPTIONS( s_parsed.render, "no words on what is being tried" ),
};

static const RfCommandTable s_table = {
    .command = "tune",
    .summary =
        "Finds the group and the tile that pay best on this path and this machine, by short renders: a row for each with memory, "
        "time, error, flicker and efficiency, and the command line of the best. Options and SCENE are those of render.",
    .files = s_files,
    .file_count = 1,
    .options = s_options,
    .option_count = sizeof s_options / sizeof s_options[0]
};

// Parses on top of the current values.
static RfResult parse( int argc, char** argv, RfTuneOptions* options, bool* help, RfError* error )
{
    RfResult result = rf_parse_options( &s_table, argc, argv, &s_scene, help, error );
    if ( result != RF_OK || *help )
        return result;
    s_parsed.render.scene = s_scene;
    result = rf_parse_estimator_option( &s_parsed.render, error );
    if ( result == RF_OK )
        rf_settle_filter( &s_parsed.render );
    if ( result == RF_OK )
        result = rf_parse_aov_option( &s_parsed.render, error );
    *options = s_parsed;
    return result;
}

RfResult rf_parse_tune_options( int argc, char** argv, RfTuneOptions* options, bool* help, RfError* error )
{
    s_parsed = ( RfTuneOptions ){ .render = rf_default_render_options(), .budget = BUDGET };
    return parse( argc, argv, options, help, error );
}

RfResult rf_parse_tune_options_over( const RfField* defaults, int argc, char** argv, RfTuneOptions* options, RfError* error )
{
    bool help;
    s_parsed = ( RfTuneOptions ){ .budget = BUDGET };
    RfResult result = rf_read_render_defaults( defaults, &s_parsed.render );
    return result == RF_OK ? parse( argc, argv, options, &help, error ) : result;
}

void rf_print_tune_help( void ) { rf_print_help( &s_table, stdout ); }

static bool is_plain( const char* text )
{
    return text[0] != '\0' &&
           text[strspn( text, "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_./,:=+-@%" )] == '\0';
}

// Control characters as $'\x1b', which bash and zsh read: no terminal obeys the command.
static void print_escaped( FILE* file, const char* text )
{
    fputs( " $'", file );
    for ( const unsigned char* c = (const unsigned char*)text; *c != '\0'; ++c )
        fprintf( file, iscntrl( *c ) || *c >= 0x80 ? "\\x%02x" : *c == '\'' || *c == '\\' ? "\\%c" : "%c", *c );
    fputc( '\'', file );
}

static void print_word( FILE* file, const char* text )
{
    char shown[8192];
    if ( is_plain( text ) )
    {
        fprintf( file, " %s", text );
        return;
    }
    if ( strcmp( rf_plain_text( text, shown, sizeof shown ), text ) != 0 )
    {
        print_escaped( file, text );
        return;
    }
    fputs( " '", file );
    for ( ; *text != '\0'; ++text )
    {
        if ( *text == '\'' )
            fputs( "'\\''", file );
        else
            fputc( *text, file );
    }
    fputc( '\'', file );
}

// Is this option (with its two dashes) one of `tune` that `render` does not take, or that the best setting replaces?
static bool is_own( const char* argument )
{
    static const char* const names[] = { "--budget", "--goal", "--svg", "--json", "--quiet", "--no-quiet", "--estimator" };
    for ( size_t i = 0; i < sizeof names / sizeof names[0]; ++i )
    {
        size_t length = strlen( names[i] );
        if ( strncmp( argument, names[i], length ) == 0 && ( argument[length] == '\0' || argument[length] == '=' ) )
            return true;
    }
    return false;
}

static bool takes_value( const char* argument )
{
    if ( strchr( argument, '=' ) != NULL )
        return false;
    for ( int i = 0; i < s_table.option_count; ++i )
    {
        if ( strcmp( argument + 2, s_options[i].name ) == 0 )
            return s_options[i].type != RF_OPTION_BOOL;
    }
    return false;
}

// The arguments have been parsed before: whatever begins with dashes is an option, up to "--".
static void print_options( FILE* file, int argc, char** argv )
{
    for ( int i = 1; i < argc && strcmp( argv[i], "--" ) != 0; ++i )
    {
        if ( strncmp( argv[i], "--", 2 ) != 0 )
            continue;
        bool own = is_own( argv[i] ), value = takes_value( argv[i] ) && i + 1 < argc;
        if ( !own )
            print_word( file, argv[i] );
        i += value;
        if ( !own && value )
            print_word( file, argv[i] );
    }
}

char* rf_tuned_command( int argc, char** argv, const RfEstimator* estimator, int group, const RfTile* tile )
{
    char *text = NULL, name[24];
    size_t size;
    FILE* file = open_memstream( &text, &size );
    if ( file == NULL )
        return NULL;
    rf_tile_name( tile, name );
    fputs( "reframe render", file );
    bool dash = s_scene[0] == '-';
    if ( !dash )
        print_word( file, s_scene );
    fprintf( file, " -o out/frame.####.exr --group %d --tile %s", group, name );
    if ( estimator != NULL )
        fprintf( file, " --estimator %s", rf_estimator_name( estimator ) );
    print_options( file, argc, argv );
    if ( dash )
    {
        fputs( " --", file );
        print_word( file, s_scene );
    }
    if ( fclose( file ) == 0 )
        return text;
    free( text );
    return NULL;
}
