// Errors and warnings on standard error, JSON results in a file or on standard output, exit statuses; signals, which ask a render to
// stop in good order.
#define _GNU_SOURCE // RTLD_DEFAULT

#include "cli/messages.h"

#include "base/plain_text.h"
#include "image/atomic_file.h"

#include <dlfcn.h>
#include <errno.h>
#include <math.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

// 0, 1, 2 (usage) or 130 (interrupted).
static int exit_status( RfResult result )
{
    switch ( result )
    {
        case RF_OK: return 0;
        case RF_ERROR_USAGE: return 2;
        case RF_ERROR_INTERRUPTED: return 130;
        default: return 1;
    }
}

#define EXPORT_INSTEAD "export it as glTF (.glb) from the program it came from"

// What to type. %zu stands for the memory that is needed, MiB.
static const char* hint_of( const RfError* error )
{
    switch ( error->remedy )
    {
        case RF_REMEDY_NONE: return "";
        case RF_REMEDY_MEMORY:
            return error->least_memory > 0 ? ": give --memory %zuM or more, or lower --size"
                                           : ": raise --memory, or lower --size or --group";
        case RF_REMEDY_THREADS: return ": lower --threads, or raise ulimit -v or -u";
        case RF_REMEDY_LIMIT: return ": lower --size, --group or --memory, or raise that limit";
        case RF_REMEDY_ESTIMATOR: return ": choose another by --estimator, or leave that option out";
        case RF_REMEDY_LAYER: return ": name one by --layer";
        case RF_REMEDY_MOTION: return ": choose by --motion X,Y";
        case RF_REMEDY_DEPTH: return ": choose by --depth NAME";
        case RF_REMEDY_FRAMES: return ": choose others by --frames";
        case RF_REMEDY_DENOISER: return ": get it by scripts/install-packages --denoiser, or name its library by --denoiser";
        case RF_REMEDY_OVERWRITE: return ": give another name or --overwrite";
        case RF_REMEDY_ACCEPT_LOSSES: return "; --accept-losses goes on without";
        case RF_REMEDY_CONVERT_MEMORY: return ": give it more by --memory, or " EXPORT_INSTEAD;
        case RF_REMEDY_CONVERT_SECONDS: return ": give it more by --timeout, or " EXPORT_INSTEAD;
    }
    return "";
}

size_t rf_whole_mib( size_t bytes ) { return ( bytes >> 20 ) + ( bytes % ( (size_t)1 << 20 ) != 0 ); }

void rf_format_error( const RfError* error, char* text, size_t size )
{
    char hint[160];
    const char* format = hint_of( error );
    const char* number = strstr( format, "%zu" );
    if ( number == NULL )
        snprintf( hint, sizeof hint, "%s", format );
    else
        snprintf( hint, sizeof hint, "%.*s%zu%s", (int)( number - format ), format, rf_whole_mib( error->least_memory ),
                  number + 3 );
    snprintf( text, size, "%s%s", error->text, hint );
}

int rf_report_error( const char* command, const RfError* error )
{
    char text[sizeof error->text + 160];
    rf_format_error( error, text, sizeof text );
    fprintf( stderr, "reframe %s: %s\n", command, text );
    return exit_status( error->code );
}

static void print_warning( void* user, const char* line )
{
    fprintf( stderr, "reframe %s: warning: %s\n", (const char*)user, line );
}

RfLog rf_stderr_log( const char* command ) { return ( RfLog ){ .fn = print_warning, .user = (void*)command }; }

void rf_print( const char* format, ... )
{
    char raw[8192], plain[8192]; // more than two of the longest names of files
    va_list args;
    va_start( args, format );
    int length = vsnprintf( raw, sizeof raw, format, args );
    va_end( args );
    bool ends = length > 0 && format[strlen( format ) - 1] == '\n';
    if ( ends && (size_t)length < sizeof raw )
        raw[length - 1] = '\0';
    printf( "%s%s", rf_plain_text( raw, plain, sizeof plain ), ends ? "\n" : "" );
}

static void keep_warning( void* user, const char* line )
{
    RfReportedWarnings* reported = user;
    print_warning( (void*)reported->command, line );
    json_array_append_new( reported->lines, rf_json_text( line ) );
}

RfLog rf_keeping_log( RfReportedWarnings* reported ) { return ( RfLog ){ .fn = keep_warning, .user = reported }; }

json_t* rf_json_texts( const char* const* texts, int count )
{
    json_t* list = json_array();
    for ( int i = 0; i < count; ++i )
        json_array_append_new( list, rf_json_text( texts[i] ) );
    return list;
}

json_t* rf_json_number( double value ) { return isfinite( value ) ? json_real( value ) : json_null(); }

json_t* rf_json_add( json_t* object, const char* format, ... )
{
    va_list args;
    va_start( args, format );
    json_t* more = json_vpack_ex( NULL, 0, format, args );
    va_end( args );
    json_object_update( object, more );
    json_decref( more );
    return object;
}

json_t* rf_set_figures( json_t* object, const RfFigure* figures )
{
    for ( ; figures->key != NULL; ++figures )
        json_object_set_new( object, figures->key, rf_json_number( figures->value ) );
    return object;
}

double rf_json_number_of( const json_t* object, const char* key )
{
    const json_t* value = json_object_get( object, key );
    return json_is_number( value ) ? json_number_value( value ) : (double)NAN;
}

json_t* rf_json_frames( const int* frames, int count )
{
    json_t* list = json_array();
    for ( int i = 0; i < count; ++i )
        json_array_append_new( list, json_integer( frames[i] ) );
    return list;
}

#define JSON_FLAGS ( JSON_INDENT( 2 ) | JSON_REAL_PRECISION( 9 ) )

static RfResult dump_to_file( const char* path, const json_t* json, RfError* error )
{
    char* text = json_dumps( json, JSON_FLAGS );
    if ( text == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory for the result", path );
    size_t length = strlen( text );
    text[length] = '\n'; // replaces the terminator
    RfResult result = rf_write_file_atomic( path, text, length + 1, error );
    free( text );
    return result;
}

RfResult rf_flush_output( RfError* error )
{
    if ( fflush( stdout ) != 0 || ferror( stdout ) )
        return rf_fail( error, RF_ERROR_IO, "standard output cannot be written: %s", strerror( errno ) );
    return RF_OK;
}

double rf_noise_percent( double relmse ) { return 100.0 * sqrt( relmse / 3.0 ); }

double rf_relmse_of_noise( double percent ) { return 3.0 * ( percent / 100.0 ) * ( percent / 100.0 ); }

void rf_format_noise( double relmse, char text[RF_NOISE_TEXT_SIZE] )
{
    double percent = rf_noise_percent( relmse );
    if ( !isfinite( percent ) )
        snprintf( text, RF_NOISE_TEXT_SIZE, "unknown" );
    else
        snprintf( text, RF_NOISE_TEXT_SIZE, percent < 99.5 ? "%.2g %%" : "%.0f %%", percent );
}

void rf_format_flicker( double f1, char text[RF_NOISE_TEXT_SIZE] ) { rf_format_noise( 3.0 * f1 * f1, text ); }

json_t* rf_denoised_json( double noisy, const RfErrorEstimate* denoised )
{
    json_t* json = json_pack( "{s:b}", "is_vague", denoised->is_vague );
    return RF_SET_FIGURES( json, { "noisy_relmse", noisy }, { "relmse", denoised->relmse }, { "low", denoised->low },
                           { "high", denoised->high } );
}

void rf_format_denoised( double noisy, const RfErrorEstimate* e, char text[RF_DENOISED_TEXT_SIZE] )
{
    char before[RF_NOISE_TEXT_SIZE], after[RF_NOISE_TEXT_SIZE], low[RF_NOISE_TEXT_SIZE], high[RF_NOISE_TEXT_SIZE];
    rf_format_noise( fmax( noisy, 0.0 ), before );
    rf_format_noise( fmax( e->relmse, 0.0 ), after );
    rf_format_noise( e->low, low );
    rf_format_noise( e->high, high );
    if ( e->low <= 0.0 )
        snprintf( text, RF_DENOISED_TEXT_SIZE, "noise %s, denoised below %s%s (bias included)", before, high,
                  e->is_vague ? " or so" : "" );
    else
        snprintf( text, RF_DENOISED_TEXT_SIZE, "noise %s, denoised %s (95 %%: %s to %s%s; bias included)", before, after, low,
                  high, e->is_vague ? " or more" : "" );
}

bool rf_prints_text( const char* json ) { return json == NULL || strcmp( json, "-" ) != 0; }

RfResult rf_write_json( const char* path, json_t* json, RfError* error )
{
    if ( json == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory for the result", path );
    RfResult result;
    if ( strcmp( path, "-" ) == 0 )
    {
        // a terminal obeys some characters beyond ASCII too
        json_dumpf( json, stdout, JSON_FLAGS | ( isatty( STDOUT_FILENO ) == 1 ? JSON_ENSURE_ASCII : 0 ) );
        fputc( '\n', stdout );
        result = rf_flush_output( error );
    }
    else
        result = dump_to_file( path, json, error );
    json_decref( json );
    return result;
}

// Nothing is left open that matters: files that are being written have temporary names.
static void on_terminate( void )
{
    static const char line[] = "reframe: a library could not go on, most likely for want of memory: close other programs\n";
    (void)!write( STDERR_FILENO, line, sizeof line - 1 );
    _exit( 1 );
}

void rf_catch_terminate( void )
{
    // std::set_terminate of the C++ runtime that Embree brings along
    void ( *( *set )( void ( * )( void ) ) )( void );
    *(void**)&set = dlsym( RTLD_DEFAULT, "_ZSt13set_terminatePFvvE" );
    if ( set != NULL )
        set( on_terminate );
}

static volatile sig_atomic_t s_interrupted;

static void on_signal( int number )
{
    (void)number;
    s_interrupted = 1;
}

void rf_catch_interrupts( void )
{
    static const int numbers[] = { SIGINT, SIGTERM, SIGHUP, SIGPIPE };
    for ( size_t i = 0; i < sizeof numbers / sizeof numbers[0]; ++i )
    {
        // These two may come several times: from the shell and the terminal, and with every line to a closed pipe.
        bool repeats = numbers[i] == SIGHUP || numbers[i] == SIGPIPE;
        struct sigaction action = { .sa_handler = on_signal }, before;
        sigemptyset( &action.sa_mask );
        // Reset: the second signal has its default action. Restart: the first does not
        // interrupt a write.
        action.sa_flags = SA_RESTART | ( repeats ? 0 : (int)SA_RESETHAND );
        if ( repeats && sigaction( numbers[i], NULL, &before ) == 0 && before.sa_handler == SIG_IGN )
            continue; // by nohup
        sigaction( numbers[i], &action, NULL );
    }
}

bool rf_is_interrupted( void ) { return s_interrupted != 0; }

bool rf_may_go_on( void* user )
{
    (void)user;
    return s_interrupted == 0;
}
