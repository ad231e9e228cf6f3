// A web server for one person on this machine: answers GET on 127.0.0.1, one request at a time, in a thread of its own. Connections
// that send nothing hold nobody up.
#ifndef REFRAME_CLI_RENDER_HTTP_SERVER_H
#define REFRAME_CLI_RENDER_HTTP_SERVER_H

#include "reframe/error.h"

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
    int port;
    RfHttpAnswer* answer;
    void* user;
    struct MHD_Daemon* daemon;
} RfHttpServer;

// Port 0: any that is free. The server may not be moved. server->port is the one in use. Fails with RF_ERROR_IO, where the port is in use, too.
RfResult rf_start_http_server( int port, RfHttpAnswer* answer, void* user, RfHttpServer* server, RfError* error );

// At once, in the midst of a reply too.
void rf_stop_http_server( RfHttpServer* server );

#endif
