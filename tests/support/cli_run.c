#include "support/cli_run.h"
#include "support/test.h"

#include <dirent.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

static char s_folder[64];
static pid_t s_child;
static CliResult s_result;

const char* cli_folder( void ) { return s_folder; }

void cli_enter( void )
{
    strcpy( s_folder, "/tmp/reframe-cli-XXXXXX" );
    assert_non_null( mkdtemp( s_folder ) );
    setenv( "R", REFRAME_BINARY, 1 );
    setenv( "VASE", REFRAME_VASE_ROOM, 1 );
    setenv( "OMP_WAIT_POLICY", "passive", 1 ); // other tests are at work beside
}

void cli_leave( void )
{
    char command[128];
    snprintf( command, sizeof command, "rm -rf '%s'", s_folder );
    assert_int_equal( system( command ), 0 );
}

int cli_enter_group( void** state )
{
    (void)state;
    cli_enter();
    return 0;
}

int cli_leave_group( void** state )
{
    (void)state;
    cli_leave();
    return 0;
}

const char* cli_path( const char* name )
{
    static char s_paths[32][512];
    static int s_next;
    char* path = s_paths[s_next++ % 32];
    snprintf( path, sizeof s_paths[0], "%s%s%s", name[0] == '/' ? "" : s_folder, name[0] == '/' ? "" : "/", name );
    return path;
}

bool cli_exists( const char* name ) { return access( cli_path( name ), F_OK ) == 0; }

void cli_write( const char* name, const void* bytes, size_t size )
{
    FILE* file = fopen( cli_path( name ), "wb" );
    assert_non_null( file );
    assert_int_equal( fwrite( bytes, 1, size, file ), size );
    assert_int_equal( fclose( file ), 0 );
}

char* cli_read( const char* name, size_t* size )
{
    const char* path = cli_path( name );
    FILE* file = fopen( path, "rb" );
    if ( file == NULL )
        fail_msg( "%s is not there", path );
    fseek( file, 0, SEEK_END );
    long length = ftell( file );
    rewind( file );
    char* bytes = malloc( (size_t)length + 1 );
    assert_non_null( bytes );
    *size = fread( bytes, 1, (size_t)length, file );
    bytes[*size] = '\0';
    fclose( file );
    return bytes;
}

json_t* cli_read_json( const char* name )
{
    size_t size;
    char* text = cli_read( name, &size );
    json_error_t fault;
    json_t* json = json_loads( text, 0, &fault );
    free( text );
    if ( json == NULL )
        fail_msg( "%s: %s", name, fault.text );
    return json;
}

RfImage cli_read_exr( const char* name )
{
    RfImage image;
    RfError error = { 0 };
    if ( rf_read_exr( cli_path( name ), &image, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    return image;
}

void cli_expect_size( const char* name, int width, int height )
{
    RfImage image = cli_read_exr( name );
    assert_int_equal( image.width, width );
    assert_int_equal( image.height, height );
    rf_destroy_image( &image );
}

float* cli_read_channel( const char* name, const char* channel, RfExrWindow* window )
{
    float* values;
    RfExrWindow own;
    RfError error = { 0 };
    if ( rf_read_exr_channels( cli_path( name ), &channel, 1, window != NULL ? window : &own, &values, &error ) == RF_OK )
        return values;
    if ( strstr( error.text, channel ) == NULL )
        fail_msg( "%s", error.text );
    return NULL;
}

const char* cli_exr_text( const char* name, const char* key )
{
    static char s_text[8192];
    return rf_read_exr_string( cli_path( name ), key, s_text, sizeof s_text, NULL ) == RF_OK ? s_text : NULL;
}

void cli_expect_exr_text( const char* name, const char* key, const char* wanted )
{
    const char* text = cli_exr_text( name, key );
    if ( text != NULL && wanted != NULL ? strcmp( text, wanted ) != 0 : text != wanted )
        fail_msg( "%s: %s is '%s', not '%s'", name, key, text != NULL ? text : "", wanted != NULL ? wanted : "" );
}

void cli_expect_exr_texts( const char* name, const char* const ( *wanted )[2], size_t count )
{
    for ( size_t i = 0; i < count; ++i )
        cli_expect_exr_text( name, wanted[i][0], wanted[i][1] );
}

int cli_count_files( const char* suffix, const char* subfolder )
{
    DIR* folder = opendir( cli_path( subfolder ) );
    if ( folder == NULL )
        return 0;
    int count = 0;
    for ( struct dirent* entry = readdir( folder ); entry != NULL; entry = readdir( folder ) )
    {
        size_t length = strlen( entry->d_name ), end = strlen( suffix );
        bool self = strcmp( entry->d_name, "." ) == 0 || strcmp( entry->d_name, ".." ) == 0;
        count += !self && length >= end && strcmp( entry->d_name + length - end, suffix ) == 0;
    }
    closedir( folder );
    return count;
}

static void start( const char* format, va_list arguments )
{
    char line[2048];
    vsnprintf( line, sizeof line, format, arguments );
    s_child = fork();
    assert_true( s_child >= 0 );
    if ( s_child > 0 )
        return;
    if ( chdir( s_folder ) != 0 || freopen( ".out", "w", stdout ) == NULL || freopen( ".err", "w", stderr ) == NULL )
        _exit( 99 );
    execl( "/bin/sh", "sh", "-c", line, (char*)NULL );
    _exit( 99 );
}

static void slurp( const char* name, char* text, size_t size )
{
    size_t length;
    char* bytes = cli_read( name, &length );
    length = length < size - 1 ? length : size - 1;
    memcpy( text, bytes, length );
    text[length] = '\0';
    free( bytes );
}

const CliResult* cli_wait( int signal_number )
{
    if ( signal_number != 0 )
        kill( s_child, signal_number );
    int status;
    assert_int_equal( waitpid( s_child, &status, 0 ), s_child );
    s_result.status = WIFEXITED( status ) ? WEXITSTATUS( status ) : 1000 + WTERMSIG( status );
    slurp( ".out", s_result.out, sizeof s_result.out );
    slurp( ".err", s_result.err, sizeof s_result.err );
    return &s_result;
}

void cli_start( const char* format, ... )
{
    va_list arguments;
    va_start( arguments, format );
    start( format, arguments );
    va_end( arguments );
}

const CliResult* cli_run( const char* format, ... )
{
    va_list arguments;
    va_start( arguments, format );
    start( format, arguments );
    va_end( arguments );
    return cli_wait( 0 );
}

const CliResult* cli_measure( const char* command, int budget )
{
    const CliResult* result;
    do
    {
        result = cli_run( "%s --budget %d", command, budget );
        budget *= 4;
    } while ( strstr( result->err, "nothing is known within the budget" ) != NULL && budget < 10000 );
    return result;
}

void cli_expect( const CliResult* result, int status, const char* part )
{
    size_t length = strlen( result->err );
    bool one_line = length > 1 && strchr( result->err, '\n' ) == result->err + length - 1;
    if ( result->status != status || ( part != NULL && ( strstr( result->err, part ) == NULL || !one_line ) ) )
        fail_msg( "wanted status %d and the line '%s', got status %d\nout: %s\nerr: %s", status, part != NULL ? part : "",
                  result->status, result->out, result->err );
}

void cli_expect_verdict( const char* text, const json_t* json, const char* first )
{
    const char *verdict = json_string_value( json_object_get( json, "verdict" ) ), *second = strchr( verdict, '\n' );
    size_t size = strlen( verdict );
    if ( strncmp( verdict, first, strlen( first ) ) != 0 || second == NULL || strchr( second + 1, '\n' ) != NULL ||
         strncmp( text, verdict, size ) != 0 || strncmp( text + size, "\n\n", 2 ) != 0 )
        fail_msg( "the verdict is '%s', and this begins otherwise: %s", verdict, text );
}

// ---- command run ----

static char s_said[2048];
static char s_json[512]; // what the last run was to write

int run_command( int ( *command )( int argc, char** argv ), int argc, char** argv )
{
    fflush( stderr );
    int kept = dup( STDERR_FILENO );
    FILE* file = tmpfile();
    assert_non_null( file );
    dup2( fileno( file ), STDERR_FILENO );
    int status = command( argc, argv );
    fflush( stderr );
    dup2( kept, STDERR_FILENO );
    close( kept );
    rewind( file );
    s_said[fread( s_said, 1, sizeof s_said - 1, file )] = '\0';
    fclose( file );
    return status;
}

int run_command_to_json( int ( *command )( int argc, char** argv ), int count, char** arguments, va_list more )
{
    for ( char* next = va_arg( more, char* ); next != NULL; next = va_arg( more, char* ) )
    {
        assert_true( count < COMMAND_ARGUMENTS );
        arguments[count++] = next;
    }
    for ( int i = 0; i + 1 < count; ++i )
    {
        if ( strcmp( arguments[i], "--json" ) == 0 )
            snprintf( s_json, sizeof s_json, "%s", arguments[i + 1] );
    }
    remove( s_json );
    return run_command( command, count, arguments );
}

json_t* load_json( void )
{
    json_t* json = json_load_file( s_json, 0, NULL );
    assert_non_null( json );
    return json;
}

void check_failed( int status, int wanted, const char* part )
{
    const char* end = strchr( s_said, '\n' );
    if ( status != wanted || strstr( s_said, part ) == NULL || end == NULL || end[1] != '\0' )
        fail_msg( "wanted %d and '%s', got %d: %s", wanted, part, status, s_said );
}

void check_done( int status )
{
    if ( status != 0 || s_said[0] != '\0' )
        fail_msg( "status %d: %s", status, s_said );
}

double number( const json_t* json, const char* key )
{
    const json_t* value = json_object_get( json, key );
    if ( !json_is_number( value ) )
        fail_msg( "%s: is no number", key );
    return json_number_value( value );
}
