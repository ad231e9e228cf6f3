// Limits of memory and processor time of containers and services: control groups, versions 1 and 2.
#ifndef REFRAME_BASE_CGROUP_H
#define REFRAME_BASE_CGROUP_H

#include <stddef.h>

// Bytes that the group `path` ("/a/b") below the mount point `root`, and all its ancestors,
// may still allocate: the limit minus what is in use, where inactive file pages count as
// free. SIZE_MAX if unlimited.
size_t rf_cgroup_free_memory( const char* root, const char* path );

// The same for the group of this process.
size_t rf_own_cgroup_free_memory( void );

// Cores' worth of time that the group and its ancestors may take, by their quotas: 1.5 is three halves of a core. INFINITY if
// unlimited. And that of this process.
double rf_cgroup_cores( const char* root, const char* path );
double rf_own_cgroup_cores( void );

#endif
