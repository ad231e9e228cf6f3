#include "support/command_run.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

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
