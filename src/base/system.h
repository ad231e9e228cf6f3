// Resources of the machine: time, memory, cores; and what control groups (versions 1 and 2) leave of them to containers and
// services.
#ifndef REFRAME_BASE_SYSTEM_H
#define REFRAME_BASE_SYSTEM_H

#include <stddef.h>

// Seconds of a monotonic clock, and CPU seconds of this thread and of all threads of the process.
double rf_wall_seconds( void );
double rf_thread_seconds( void );
double rf_process_seconds( void );

// Bytes that the limits of the process still leave it: of its control groups, and of ulimit -v. SIZE_MAX: no limit.
size_t rf_permitted_memory( void );

// Available memory in bytes, without swapping and within these limits; 1 GiB if unknown.
size_t rf_free_memory( void );

#define RF_BYTES_TEXT_SIZE 32

// Formats an amount of memory: "96 MiB", or "1500 KiB" where it is no whole number of MiB.
void rf_format_memory( size_t bytes, char text[RF_BYTES_TEXT_SIZE] );

// Cores this process may use, ≥ 1: those of its CPU set (taskset), or as many as the quota of its control groups is worth.
int rf_core_count( void );

// How many threads can be at work at the same time, at most `wanted`: the limits of the process (ulimit -u, -v) and of its control
// groups bound them. OpenMP and TBB end the program where they do not get theirs.
int rf_possible_threads( int wanted );

// Bytes that the group `path` ("/a/b") below the mount point `root`, and all its ancestors,
// may still allocate: the limit minus what is in use, where inactive file pages count as
// free. SIZE_MAX if unlimited.
size_t rf_cgroup_free_memory( const char* root, const char* path );

// Cores' worth of time that the group and its ancestors may take, by their quotas: 1.5 is three halves of a core. INFINITY if
// unlimited. And that of this process.
double rf_cgroup_cores( const char* root, const char* path );

#endif
