// The file in which an interrupted render keeps the films of the frames in work, for --resume. It lies beside the frames and is
// named after the oldest in work: shot.0012.films where that will be shot.0012.exr.
#ifndef REFRAME_CLI_RENDER_FILMS_FILE_H
#define REFRAME_CLI_RENDER_FILMS_FILE_H

#include "image/atomic_file.h"
#include "reframe/output.h"

#include <stdint.h>
#include <stdio.h>

#define RF_FILMS_NAME_SIZE 4096

// The frames that are left of a render: indices from 0, ascending.
typedef struct RfFramesLeft
{
    const RfOutput* output;
    const int* frames;
    int count;
} RfFramesLeft;

// The name of the file, of those that begin with frame `frame`.
RfResult rf_films_file_name( const RfOutput* output, int frame, char name[RF_FILMS_NAME_SIZE], RfError* error );

#define RF_FILMS_BLOCK ( 1 << 16 )

// A file being written, in blocks.
typedef struct RfFilmsWriter
{
    char name[RF_FILMS_NAME_SIZE];
    RfAtomicFile file;
    unsigned char block[RF_FILMS_BLOCK];
    size_t used;          // of the block
    uint64_t bytes, hash; // of those before it
    bool open;
} RfFilmsWriter;

// Bytes go to the file by rf_append_films; it is there once it is ended, and not at all after a failure.
RfResult rf_create_films_file( const RfFramesLeft* left, RfFilmsWriter* writer, RfError* error );
RfResult rf_append_films( RfFilmsWriter* writer, const void* bytes, size_t size, RfError* error );
RfResult rf_end_films_file( RfFilmsWriter* writer, RfError* error );

typedef enum RfFilmsState
{
    RF_FILMS_MISSING,
    RF_FILMS_SAME,         // of this render and these frames
    RF_FILMS_OTHER_FRAMES, // of this render, but other frames were left of it
    RF_FILMS_OTHER,        // of another render
    RF_FILMS_UNREADABLE,   // no whole file of this kind
} RfFilmsState;

// Reads the whole file. With RF_FILMS_SAME *file is open where the bytes of rf_append_films begin; the caller closes it.
// `error` says what is wrong with the others.
RfFilmsState rf_open_films_file( const RfFramesLeft* left, FILE** file, RfError* error );

// Removes the file of a frame that is finished, if it is there.
void rf_remove_films_file( const RfOutput* output, int frame );

#endif
