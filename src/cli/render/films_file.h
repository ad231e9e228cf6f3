// The file in which a render keeps the films of the frames in work, for --resume: when it is interrupted, and from time to time. It
// lies beside the frames and is named after the oldest that was in work: shot.0012.films where that will be shot.0012.exr.
#ifndef REFRAME_CLI_RENDER_FILMS_FILE_H
#define REFRAME_CLI_RENDER_FILMS_FILE_H

#include "image/atomic_file.h"
#include "reframe/output.h"

#include <stdio.h>

#define RF_FILMS_NAME_SIZE 4096

// The frames that are left of a render, and those that are finished: indices from 0, ascending.
typedef struct RfFramesLeft
{
    const RfOutput* output;
    int *frames, count; // with room for all
    int *kept, kept_count;
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
// `error` says what is wrong with the others. Films that were saved before some frames were finished lie under the name of a
// finished one: those frames go from `kept` back to `frames`.
RfFilmsState rf_open_films_file( RfFramesLeft* left, FILE** file, RfError* error );

// Removes the file of those that begin with this frame, if it is there.
void rf_remove_films_file( const RfOutput* output, int frame );

// When films are saved of a render that goes on.
typedef struct RfAutosave
{
    double interval;           // seconds between two, as asked for
    double began, next, since; // clock: of the first question, of the next save, of that under way
    double spent;              // seconds of all so far
    double told;               // the interval that the user knows of
    bool in_trouble;           // without room, or the last could not be written: said once
} RfAutosave;

// Is it time to save films that take so many bytes? Without room for them on the disk it is not, and `error` says so once.
bool rf_is_save_due( RfAutosave* autosave, const RfOutput* output, size_t bytes, RfError* error );

// After it: sets when the next is due, so that saving takes at most 1 % of the time. Returns the interval where it is much longer than
// the one that the user knows, else 0.
double rf_note_saved( RfAutosave* autosave );

#endif
