// Files that are whole or not there: bytes go to a temporary name in the same
// folder, and only after they reached the disk does the file get its name.
// Whoever looks at the final name sees the old file or the new, never a part.
#ifndef REFRAME_IMAGE_ATOMIC_FILE_H
#define REFRAME_IMAGE_ATOMIC_FILE_H

#include "reframe/error.h"

#include <stddef.h>

typedef struct RfAtomicFile
{
    const char* path;   // as the caller named it; must outlive this
    int fd;             // open for reading and writing
    int folder;         // descriptor of the folder
    char base[256];     // the final name inside the folder
    char temporary[64]; // the present name inside the folder
} RfAtomicFile;

// Makes the temporary file. A symbolic link as the last component is followed.
// A target that exists and is no regular file (a folder, a device) is refused.
RfResult rf_open_atomic_file( const char* path, RfAtomicFile* file, RfError* error );

// Appends bytes. On failure the caller discards.
RfResult rf_append_atomic_file( RfAtomicFile* file, const void* bytes, size_t size, RfError* error );

// fsync, rename, fsync of the folder. On failure the temporary file is gone and
// the final name untouched, unless all that failed was the folder's fsync.
RfResult rf_commit_atomic_file( RfAtomicFile* file, RfError* error );

// Removes the temporary file.
void rf_discard_atomic_file( RfAtomicFile* file );

// All of the above for bytes in memory: JSON, text. A target that is a pipe or
// a device, such as /dev/stdout or /dev/null, is written in place.
RfResult rf_write_file_atomic( const char* path, const void* bytes, size_t size, RfError* error );

// One line about a failed system call: file, what failed, why, what to do.
RfResult rf_fail_io( const char* path, const char* what, int error_number, RfError* error );

#endif
