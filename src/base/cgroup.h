// What a container or a service may hold: control groups, version 2.
#ifndef REFRAME_BASE_CGROUP_H
#define REFRAME_BASE_CGROUP_H

#include <stddef.h>

// Bytes that the group `path` ("/a/b") below the file system's `root` and all groups
// above it may still take: memory.max less memory.current, of which file pages that
// are not in use are had back. SIZE_MAX where there is no limit.
size_t rf_cgroup_free_memory( const char* root, const char* path );

// The same of this process.
size_t rf_own_cgroup_free_memory( void );

#endif
