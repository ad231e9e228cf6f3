// render --preview: a file that shows the frame in work, and the live page, whatever is sent to its port.
#include "support/cli_run.h"
#include "support/test.h"

#include <arpa/inet.h>
#include <jansson.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#define SMALL "--frames 1-3 --size 32x18 --spp 4 --group 1 --quiet "
#ifdef REFRAME_SANITIZED
#define SOME "60"
#else
#define SOME "400" // seconds for a frame
#endif
// Until it is interrupted.
#define ENDLESS "--frames 1-3 --size 64x36 --spp 100000 --group 0 "

static void wait_a_moment( void ) { nanosleep( &( struct timespec ){ 0, 5000000 }, NULL ); }

static void wait_for( const char* name )
{
    for ( int i = 0; i < 12000 && !cli_exists( name ); ++i )
        wait_a_moment();
    assert_true( cli_exists( name ) );
}

// The frames stay the same bits, and the last preview is there.
TEST( test_file_changes_nothing )
{
    cli_expect( cli_run( "$R render $VASE -o a/f.####.exr --preview a.png " SMALL "&& $R render $VASE -o b/f.####.exr " SMALL
                         "&& for f in a/*; do cmp $f b/${f#*/} || exit 1; done" ),
                0, NULL );
    size_t size;
    AUTO_FREE char* bytes = cli_read( "a.png", &size );
    assert_memory_equal( bytes, "\x89PNG", 4 );
    assert_int_equal( cli_count_files( ".tmp", "." ), 0 );
}

// From the first pass on, with a picture of the frame's size by the tone curve of `png`.
TEST( test_file_comes_early )
{
    cli_start( "exec $R render $VASE -o e/f.####.exr --preview e.png --quiet " ENDLESS );
    wait_for( "e.png" );
    cli_expect( cli_wait( SIGINT ), 130, "0 of 3 frames are finished" );
    size_t size;
    AUTO_FREE unsigned char* bytes = (unsigned char*)cli_read( "e.png", &size );
    assert_true( size > 24 && bytes[19] == 64 && bytes[23] == 36 );
}

TEST( test_what_cannot_be_shown )
{
    static const struct
    {
        const char* preview;
        int status;
        const char* words;
    } cases[] = { { "no/such/x.png", 1, "--preview: no/such: this folder cannot be made" },
                  { "folder.png", 1, "--preview: folder.png: is a folder" },
                  { "x.jpg", 2, "--preview: x.jpg: ends as a file of another kind: name it .png" },
                  { "x", 2, "--preview: expected a name that ends in .png or a port from 0 to 65535, got 'x'" },
                  { "65536", 2, "got '65536'" } };
    cli_expect( cli_run( "mkdir folder.png" ), 0, NULL );
    for ( size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i )
        cli_expect( cli_run( "$R render $VASE -o c/f.####.exr --preview %s " SMALL, cases[i].preview ), cases[i].status,
                    cases[i].words );
    assert_int_equal( cli_count_files( ".exr", "c" ), 0 );
}

// A folder that goes away in the midst: a warning, and the frames are whole.
TEST( test_later_failures_are_a_warning )
{
    cli_expect( cli_run( "mkdir g" ), 0, NULL );
    cli_start( "exec $R render $VASE -o h/f.####.exr --frames 1-2 --size 64x36 --spp 900 --group 0 --quiet --preview g/x.png" );
    wait_for( "g/x.png" );
    char from[512], to[512];
    snprintf( from, sizeof from, "%s/g", cli_folder() );
    snprintf( to, sizeof to, "%s/gone", cli_folder() );
    assert_int_equal( rename( from, to ), 0 );
    const CliResult* result = cli_wait( 0 );
    assert_int_equal( result->status, 0 );
    const char* warning = strstr( result->err, "--preview: g/x.png: " );
    assert_true( warning == NULL || strstr( warning + 1, "--preview" ) == NULL ); // none on a machine that is very fast
    assert_int_equal( cli_count_files( ".exr", "h" ), 2 );
}

// A client of the page.

static int connect_to( int port )
{
    struct sockaddr_in address = { .sin_family = AF_INET, .sin_port = htons( (uint16_t)port ) };
    address.sin_addr.s_addr = htonl( INADDR_LOOPBACK );
    int client = socket( AF_INET, SOCK_STREAM, 0 );
    struct timeval most = { 60, 0 };
    setsockopt( client, SOL_SOCKET, SO_RCVTIMEO, &most, sizeof most );
    if ( connect( client, (struct sockaddr*)&address, sizeof address ) != 0 )
    {
        close( client );
        return -1;
    }
    return client;
}

// What is answered to some bytes; to be freed. "" for nothing.
static char* ask( int port, const void* bytes, size_t size )
{
    char* reply = calloc( 1, 1 << 20 );
    size_t used = 0;
    int client = connect_to( port );
    assert_true( client >= 0 && reply != NULL );
    (void)!send( client, bytes, size, MSG_NOSIGNAL );
    shutdown( client, SHUT_WR );
    for ( ssize_t got; used < ( 1 << 20 ) - 1 && ( got = recv( client, reply + used, ( 1 << 20 ) - 1 - used, 0 ) ) > 0; )
        used += (size_t)got;
    close( client );
    return reply;
}

static char* get( int port, const char* path, const char* host )
{
    char request[512];
    int size = snprintf( request, sizeof request, "GET %s HTTP/1.1\r\nHost: %s:%d\r\nAccept: */*\r\n\r\n", path, host, port );
    return ask( port, request, (size_t)size );
}

static void expect_reply( int port, const char* path, const char* host, const char* status, const char* part )
{
    AUTO_FREE char* reply = get( port, path, host );
    if ( strncmp( reply, "HTTP/1.1 ", 9 ) != 0 || strncmp( reply + 9, status, 3 ) != 0 || strstr( reply, part ) == NULL )
        fail_msg( "%s of %s: %.300s", path, host, reply );
}

static json_t* status_of( int port )
{
    AUTO_FREE char* reply = get( port, "/status", "localhost" );
    const char* body = strstr( reply, "\r\n\r\n" );
    json_t* json = body != NULL ? json_loads( body + 4, 0, NULL ) : NULL;
    assert_non_null( json );
    return json;
}

static double value_of( int port, const char* key )
{
    json_auto_t* json = status_of( port );
    double value = json_number_value( json_object_get( json, key ) );
    return value;
}

// The program says which port it found.
static int start_page( const char* options )
{
    int port = 0;
    cli_expect( cli_run( "rm -f said" ), 0, NULL ); // else the port of the render before may be read
    cli_start( "exec $R render $VASE --preview 0 %s 2> said", options );
    for ( int i = 0; i < 12000 && port == 0; ++i )
    {
        wait_a_moment();
        size_t size;
        AUTO_FREE char* said = cli_exists( "said" ) ? cli_read( "said", &size ) : NULL;
        const char* at = said != NULL ? strstr( said, "http://127.0.0.1:" ) : NULL;
        port = at != NULL && strchr( at, '\n' ) != NULL ? atoi( at + 17 ) : 0;
    }
    assert_true( port > 0 );
    return port;
}

static size_t finished_frames( int port )
{
    json_auto_t* json = status_of( port );
    size_t count = json_array_size( json_object_get( json, "finished" ) );
    return count;
}

TEST( test_page_shows_what_goes_on )
{
    int port = start_page( "-o l/f.####.exr --frames 2-4 --size 64x36 --spp " SOME " --group 0 --aov depth,albedo" );
    for ( int i = 0; i < 12000 && ( value_of( port, "version" ) < 1.0 || finished_frames( port ) < 1 ); ++i )
        wait_a_moment();
    json_auto_t* json = status_of( port );
    assert_int_equal( (int)json_integer_value( json_object_get( json, "frames" ) ), 3 );
    assert_in_range( json_integer_value( json_object_get( json, "frame" ) ), 2, 4 );
    assert_true( json_number_value( json_object_get( json, "spp" ) ) >= 1.0 );
    assert_string_equal( json_string_value( json_object_get( json, "output" ) ), "l/f.####.exr" );
    const json_t *passes = json_object_get( json, "passes" ), *albedo = json_array_get( passes, 0 );
    const json_t* depth = json_array_get( passes, 1 );
    assert_int_equal( json_array_size( passes ), 2 );
    assert_string_equal( json_string_value( json_object_get( albedo, "name" ) ), "albedo" );
    assert_true( json_is_true( json_object_get( albedo, "light" ) ) && json_is_false( json_object_get( depth, "light" ) ) );
    expect_reply( port, "/", "127.0.0.1", "200", "</html>" );
    expect_reply( port, "/?x", "localhost", "200", "decodeFrame" );
    expect_reply( port, "/preview", "localhost", "200", "application/octet-stream" );
    expect_reply( port, "/frame/2", "localhost", "200", "max-age" );
    expect_reply( port, "/frame/2/0", "localhost", "200", "application/octet-stream" ); // a pass
    expect_reply( port, "/frame/2/2", "localhost", "404", "" );
    expect_reply( port, "/frame/2/", "localhost", "404", "" );
    expect_reply( port, "/frame/2/0x", "localhost", "404", "" );
    expect_reply( port, "/frame/1", "localhost", "404", "" ); // not of this render
    expect_reply( port, "/frame/4", "localhost", "404", "" ); // not finished
    expect_reply( port, "/frame/../../said", "localhost", "404", "" );
    expect_reply( port, "/said", "localhost", "404", "" );
    expect_reply( port, "/", "example.org", "403", "" );
    expect_reply( port, "/", "localhost.example.org", "403", "" );
    assert_int_equal( cli_wait( SIGINT )->status, 130 );
    assert_int_equal( connect_to( port ), -1 );
}

// Connections that send nothing, or half a request, keep nobody from the page. The render goes on and ends at once when it is told to.
TEST( test_garbage_does_no_harm )
{
    int port = start_page( "-o n/f.####.exr " ENDLESS );
    char *noise = malloc( 100000 ), *reply;
    uint32_t seed = 1;
    for ( int i = 0; i < 100000; ++i )
        noise[i] = (char)( ( seed = seed * 1664525u + 1013904223u ) >> 24 );
    static const char* const requests[] = { "",
                                            "\r\n\r\n",
                                            "GET\r\n\r\n",
                                            "GET / \n\n",
                                            "POST / HTTP/1.1\r\nHost: localhost\r\n\r\n",
                                            "GET http://localhost/ HTTP/1.1\r\n\r\n",
                                            "GET /\r\n\r\n",
                                            "HEAD / HTTP/1.0\r\n\r\n" };
    for ( size_t i = 0; i < sizeof requests / sizeof requests[0]; ++i )
    {
        reply = ask( port, requests[i], strlen( requests[i] ) );
        assert_null( strstr( reply, "200 OK" ) );
        free( reply );
    }
    free( ask( port, noise, 100000 ) );
    memset( noise, 'a', 100000 );
    memcpy( noise, "GET /", 5 );
    free( ask( port, noise, 100000 ) );
    int idle[12];
    for ( int i = 0; i < 12; ++i )
        idle[i] = connect_to( port );
    expect_reply( port, "/", "localhost", "200", "</html>" );
    for ( int i = 0; i < 12; ++i )
    {
        assert_int_equal( recv( idle[i], noise, 1, MSG_DONTWAIT ), -1 ); // not closed: the page came while they were there
        close( idle[i] );
    }
    int half = connect_to( port );
    (void)!send( half, "GET / HT", 8, MSG_NOSIGNAL );
    wait_a_moment();
    struct timespec began, ended;
    clock_gettime( CLOCK_MONOTONIC, &began );
    cli_wait( SIGINT );
    clock_gettime( CLOCK_MONOTONIC, &ended );
    assert_true( ended.tv_sec - began.tv_sec < 60 );
    close( half );
    free( noise );
    size_t size;
    AUTO_FREE char* said = cli_read( "said", &size );
    assert_non_null( strstr( said, "interrupted: 0 of 3 frames" ) );
}

// The page in a browser, by tests/browser/check-live.js.
TEST( test_page_in_a_browser )
{
    char line[1024];
    int port = start_page( "-o v/f.####.exr --frames 1-40 --size 96x54 --spp " SOME " --group 0 --aov depth" );
    snprintf( line, sizeof line,
              "REFRAME_NODE_MODULES='" REFRAME_SOURCE_DIR "/out/browser/node_modules' node '" REFRAME_SOURCE_DIR
              "/tests/browser/check-live.js' http://127.0.0.1:%d/",
              port );
    int status = system( "command -v node > /dev/null" ) == 0 ? system( line ) : 77 << 8;
    cli_wait( SIGINT );
    if ( status == 77 << 8 )
        skip();
    assert_int_equal( status, 0 );
}

TEST( test_port_in_use )
{
    struct sockaddr_in address = { .sin_family = AF_INET };
    socklen_t size = sizeof address;
    address.sin_addr.s_addr = htonl( INADDR_LOOPBACK );
    int taken = socket( AF_INET, SOCK_STREAM, 0 );
    assert_int_equal( bind( taken, (struct sockaddr*)&address, sizeof address ), 0 );
    assert_int_equal( listen( taken, 1 ), 0 );
    getsockname( taken, (struct sockaddr*)&address, &size );
    cli_expect( cli_run( "$R render $VASE -o u/f.####.exr --preview :%d " SMALL, ntohs( address.sin_port ) ), 1,
                "is in use: choose another, or 0 for any that is free" );
    close( taken );
}

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )
