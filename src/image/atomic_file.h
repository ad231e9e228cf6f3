// Files written atomically: bytes go to a temporary file in the same folder, which is renamed
// to the final name only after they reached the disk. A reader of the final name sees the old
// file or the new one, never a part.
#ifndef REFRAME_IMAGE_ATOMIC_FILE_H
#define REFRAME_IMAGE_ATOMIC_FILE_H

#include "reframe/error.h"

typedef struct RfAtomicFile
{
    const char* path;   // as given by the caller; must outlive this
    int fd;             // open for reading and writing
    int folder;         // descriptor of the folder
    char base[256];     // final name within the folder
    char temporary[64]; // temporary name within the folder
    bool unsynced;      // set by the caller: it need not survive a crash of the machine
} RfAtomicFile;

// Creates the temporary file. A symbolic link as the last component is followed. An existing
// target that is not a regular file (a folder, a device) is rejected.
RfResult rf_open_atomic_file( const char* path, RfAtomicFile* file, RfError* error );

// The folder of a file name, "." where it has none. Fails with RF_ERROR_USAGE where it has no room.
RfResult rf_folder_of_file( const char* path, char* folder, size_t size, RfError* error );

// Tries, before the work, whether a file can be written later, and leaves one that is there as it is. Makes its folder where it is
// missing: the last part only, since a mistyped path should not leave a tree behind.
RfResult rf_try_output_file( const char* path, RfError* error );

// Appends bytes. After a failure the caller discards the file.
RfResult rf_append_atomic_file( RfAtomicFile* file, const void* bytes, size_t size, RfError* error );

// After a failure discards the file and returns that; else fsync, rename, fsync of the folder. On failure the temporary file is gone
// and the final name untouched, unless only the fsync of the folder failed.
RfResult rf_end_atomic_file( RfAtomicFile* file, RfResult result, RfError* error );

// Removes the temporary file.
void rf_discard_atomic_file( RfAtomicFile* file );

// Removes temporary files that killed processes left in a folder. Those in use are locked, or younger
// than a second.
void rf_remove_leftovers( const char* folder );

// Writes bytes from memory atomically. A target that is a pipe or a device, such as
// /dev/stdout or /dev/null, is written in place.
RfResult rf_write_file_atomic( const char* path, const void* bytes, size_t size, RfError* error );

// Fails with RF_ERROR_IO; the message gives the file, what failed, why, and what to do.
RfResult rf_fail_io( const char* path, const char* what, int error_number, RfError* error );

#endif
