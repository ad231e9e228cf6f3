// A web server for one person on this machine: answers GET on 127.0.0.1, one request at a time, in a thread of its own. Whatever is
// sent to it, it neither blocks nor ends the program: requests are short, and both sides of a connection have seconds.
#ifndef REFRAME_CLI_RENDER_HTTP_SERVER_H
#define REFRAME_CLI_RENDER_HTTP_SERVER_H

#include "reframe/error.h"

#include <pthread.h>
#include <stdbool.h>
#include <stddef.h>

typedef struct RfHttpReply
{
    const char* type;     // "text/html"
    const char* parts[8]; // texts and bytes, in turn; as many as have a size
    size_t sizes[8];
    void* owned; // freed when it is sent; or NULL
    bool stays;  // the browser may keep it
} RfHttpReply;

// Fills the reply to a path such as "/status"; false: there is no such thing. Called by the server's thread.
typedef bool RfHttpAnswer( void* user, const char* path, RfHttpReply* reply );

typedef struct RfHttpServer
{
    int listener, wake[2];
    int port;
    RfHttpAnswer* answer;
    void* user;
    pthread_t thread;
} RfHttpServer;

// Port 0: any that is free. server->port is the one in use. Fails with RF_ERROR_IO, where the port is in use, too.
RfResult rf_start_http_server( int port, RfHttpAnswer* answer, void* user, RfHttpServer* server, RfError* error );

// At once, in the midst of a reply too.
void rf_stop_http_server( RfHttpServer* server );

#endif
