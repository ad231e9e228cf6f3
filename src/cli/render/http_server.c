// HTTP/1.0 over a socket of the loopback interface: a request's first line and its host, then a reply and the end.
#define _GNU_SOURCE // accept4, pipe2
#include "cli/render/http_server.h"

#include "trace/trace.h"

#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#define MOST_REQUEST 8192
#define REQUEST_SECONDS 2.0 // for a request
#define REPLY_SECONDS 20.0  // for a reply

static double now( void )
{
    struct timespec time;
    clock_gettime( CLOCK_MONOTONIC, &time );
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

// Waits until the socket is ready; false at the deadline, and when the server is to stop.
static bool wait_for( const RfHttpServer* server, int socket, short events, double deadline )
{
    for ( ;; )
    {
        struct pollfd polled[2] = { { .fd = socket, .events = events }, { .fd = server->wake[0], .events = POLLIN } };
        double left = deadline - now();
        int ready = left > 0.0 ? poll( polled, 2, (int)( 1000.0 * left ) + 1 ) : 0;
        if ( ready < 0 && errno == EINTR )
            continue;
        return ready > 0 && polled[1].revents == 0;
    }
}

// The request up to its empty line; false where there is none in time.
static bool read_request( const RfHttpServer* server, int client, char request[MOST_REQUEST] )
{
    size_t used = 0;
    double deadline = now() + REQUEST_SECONDS;
    while ( used < MOST_REQUEST - 1 && wait_for( server, client, POLLIN, deadline ) )
    {
        ssize_t got = recv( client, request + used, MOST_REQUEST - 1 - used, 0 );
        if ( got < 0 && ( errno == EINTR || errno == EAGAIN ) )
            continue;
        if ( got <= 0 )
            return false;
        used += (size_t)got;
        request[used] = '\0';
        if ( strlen( request ) < used )
            return false; // zero bytes
        if ( strstr( request, "\r\n\r\n" ) != NULL || strstr( request, "\n\n" ) != NULL )
            return true;
    }
    return false;
}

static bool send_all( const RfHttpServer* server, int client, const char* bytes, size_t size, double deadline )
{
    while ( size > 0 )
    {
        ssize_t sent = send( client, bytes, size, MSG_NOSIGNAL );
        if ( sent > 0 )
        {
            bytes += sent;
            size -= (size_t)sent;
            continue;
        }
        if ( sent < 0 && errno != EAGAIN && errno != EINTR )
            return false;
        if ( !wait_for( server, client, POLLOUT, deadline ) )
            return false;
    }
    return true;
}

// Another page that the browser shows could come here under a name of its own (DNS rebinding), but not under these.
static bool is_for_us( const char* request )
{
    static const char* const names[] = { "127.0.0.1", "localhost" };
    const char* line = request;
    while ( ( line = strchr( line, '\n' ) ) != NULL )
    {
        line += 1;
        if ( strncasecmp( line, "host:", 5 ) != 0 )
            continue;
        const char* host = line + 5 + strspn( line + 5, " \t" );
        for ( size_t i = 0; i < sizeof names / sizeof names[0]; ++i )
        {
            size_t length = strlen( names[i] );
            if ( strncasecmp( host, names[i], length ) == 0 && strchr( ":\r\n", host[length] ) != NULL )
                return true;
        }
        return false;
    }
    return false;
}

// The path of a request "GET /path?query HTTP/1.1", cut off in place; NULL: it is none.
static char* path_of( char* request )
{
    if ( strncmp( request, "GET /", 5 ) != 0 )
        return NULL;
    char* path = request + 4;
    size_t length = strcspn( path, " ?\r\n" );
    bool ends = path[length] == ' ' || path[length] == '?';
    path[length] = '\0';
    return ends ? path : NULL;
}

static void send_reply( const RfHttpServer* server, int client, const char* status, const RfHttpReply* reply )
{
    char head[512];
    size_t size = 0;
    double deadline = now() + REPLY_SECONDS;
    for ( size_t i = 0; i < sizeof reply->sizes / sizeof reply->sizes[0]; ++i )
        size += reply->sizes[i];
    int length = snprintf( head, sizeof head,
                           "HTTP/1.0 %s\r\nContent-Type: %s\r\nContent-Length: %zu\r\nCache-Control: %s\r\n"
                           "X-Content-Type-Options: nosniff\r\nConnection: close\r\n\r\n",
                           status, reply->type, size, reply->stays ? "max-age=86400" : "no-store" );
    bool sent = send_all( server, client, head, (size_t)length, deadline );
    for ( size_t i = 0; i < sizeof reply->sizes / sizeof reply->sizes[0] && sent; ++i )
        sent = send_all( server, client, reply->parts[i], reply->sizes[i], deadline );
}

static void serve( const RfHttpServer* server, int client )
{
    char request[MOST_REQUEST];
    RfHttpReply reply = { .type = "text/plain" };
    const char* status = "200 OK";
    if ( !read_request( server, client, request ) )
        return;
    bool for_us = is_for_us( request );
    char* path = path_of( request );
    if ( path == NULL )
        status = "400 Bad Request";
    else if ( !for_us )
        status = "403 Forbidden";
    else if ( !server->answer( server->user, path, &reply ) )
    {
        status = "404 Not Found";
        reply = ( RfHttpReply ){ .type = "text/plain", .owned = reply.owned };
    }
    send_reply( server, client, status, &reply );
    free( reply.owned );
}

static void* run( void* user )
{
    const RfHttpServer* server = user;
    rf_set_float_mode();
    for ( ;; )
    {
        struct pollfd polled[2] = { { .fd = server->listener, .events = POLLIN }, { .fd = server->wake[0], .events = POLLIN } };
        if ( poll( polled, 2, -1 ) < 0 )
        {
            if ( errno == EINTR )
                continue;
            break;
        }
        if ( polled[1].revents != 0 )
            break;
        int client = accept4( server->listener, NULL, NULL, SOCK_NONBLOCK | SOCK_CLOEXEC );
        if ( client < 0 )
        {
            if ( errno == EMFILE || errno == ENFILE || errno == ENOMEM ) // the connection waits: do not spin
                wait_for( server, -1, 0, now() + 1.0 );
            continue;
        }
        serve( server, client );
        close( client );
    }
    return NULL;
}

static RfResult fail_port( int port, const char* what, RfError* error )
{
    if ( errno == EADDRINUSE )
        return rf_fail( error, RF_ERROR_IO, "port %d: is in use: choose another, or 0 for any that is free", port );
    return rf_fail( error, RF_ERROR_IO, "port %d: %s: %s: choose another", port, what, strerror( errno ) );
}

static RfResult listen_on( int port, RfHttpServer* server, RfError* error )
{
    struct sockaddr_in address = { .sin_family = AF_INET,
                                   .sin_port = htons( (uint16_t)port ),
                                   .sin_addr = { .s_addr = htonl( INADDR_LOOPBACK ) } };
    socklen_t size = sizeof address;
    int one = 1;
    server->listener = socket( AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0 );
    if ( server->listener < 0 )
        return fail_port( port, "no socket", error );
    (void)setsockopt( server->listener, SOL_SOCKET, SO_REUSEADDR, &one, sizeof one );
    if ( bind( server->listener, (struct sockaddr*)&address, sizeof address ) != 0 || listen( server->listener, 16 ) != 0 ||
         getsockname( server->listener, (struct sockaddr*)&address, &size ) != 0 )
        return fail_port( port, "cannot be used", error );
    server->port = ntohs( address.sin_port );
    return RF_OK;
}

static void close_all( const RfHttpServer* server )
{
    const int all[] = { server->listener, server->wake[0], server->wake[1] };
    for ( int i = 0; i < 3; ++i )
    {
        if ( all[i] >= 0 )
            close( all[i] );
    }
}

RfResult rf_start_http_server( int port, RfHttpAnswer* answer, void* user, RfHttpServer* server, RfError* error )
{
    *server = ( RfHttpServer ){ .listener = -1, .wake = { -1, -1 }, .answer = answer, .user = user };
    RfResult result = listen_on( port, server, error );
    if ( result == RF_OK && pipe2( server->wake, O_CLOEXEC ) != 0 )
        result = fail_port( port, "no pipe", error );
    if ( result == RF_OK && ( errno = pthread_create( &server->thread, NULL, run, server ) ) != 0 )
        result = fail_port( port, "no thread", error );
    if ( result != RF_OK )
        close_all( server );
    return result;
}

void rf_stop_http_server( RfHttpServer* server )
{
    (void)!write( server->wake[1], "", 1 );
    pthread_join( server->thread, NULL );
    close_all( server );
}
