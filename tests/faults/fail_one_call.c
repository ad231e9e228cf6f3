// A library for LD_PRELOAD that lets a single call of a program fail, as a full disk or memory would. Tests only.
//
//   FAIL_CALL    which calls count: open, write, fsync, rename, close, read, or alloc
//   FAIL_AT      number of the call that fails, from 1; 0: none
//   FAIL_REPORT  file that gets the number of such calls at exit, and the word "failed" if one did
//
// Files under /proc, /sys and /dev do not count, nor do calls before main.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <unistd.h>

static atomic_long s_calls, s_failed;
static long s_at;
static int s_kind; // index into s_kinds
static bool s_ready;
static _Thread_local int s_inside;

static const char* const s_kinds[] = { "", "open", "write", "fsync", "rename", "close", "read", "alloc" };
enum
{
    NONE,
    OPEN,
    WRITE,
    FSYNC,
    RENAME,
    CLOSE,
    READ,
    ALLOC,
    KINDS
};

static void report( void )
{
    const char* name = getenv( "FAIL_REPORT" );
    if ( name == NULL )
        return;
    int file = (int)syscall( SYS_openat, AT_FDCWD, name, O_WRONLY | O_CREAT | O_TRUNC, 0666 );
    char text[64];
    int length = snprintf( text, sizeof text, "%ld%s\n", atomic_load( &s_calls ), atomic_load( &s_failed ) ? " failed" : "" );
    (void)!syscall( SYS_write, file, text, (size_t)length );
    syscall( SYS_close, file );
}

__attribute__( ( constructor ) ) static void start( void )
{
    const char *kind = getenv( "FAIL_CALL" ), *at = getenv( "FAIL_AT" );
    for ( int k = 1; kind != NULL && k < KINDS; ++k )
        s_kind = strcmp( kind, s_kinds[k] ) == 0 ? k : s_kind;
    s_at = at != NULL ? strtol( at, NULL, 10 ) : 0;
    unsetenv( "LD_PRELOAD" ); // children are not meant
    s_ready = true;
}

__attribute__( ( destructor ) ) static void end( void )
{
    s_ready = false;
    report();
}

// Counts a call; true if it is to fail.
static bool fails( int kind )
{
    if ( !s_ready || kind != s_kind || s_inside > 0 )
        return false;
    bool now = atomic_fetch_add( &s_calls, 1 ) + 1 == s_at;
    if ( now )
        atomic_store( &s_failed, 1 );
    return now;
}

static bool counts( const char* path )
{
    return strncmp( path, "/proc", 5 ) != 0 && strncmp( path, "/sys", 4 ) != 0 && strncmp( path, "/dev", 4 ) != 0;
}

static void* next( const char* name )
{
    s_inside += 1;
    void* function = dlsym( RTLD_NEXT, name );
    s_inside -= 1;
    return function;
}

// The function that a call would reach without this library.
#define NEXT( function )                                                                                                         \
    static __typeof__( function )* s_next;                                                                                       \
    if ( s_next == NULL )                                                                                                        \
    *(void**)&s_next = next( #function )

static int open_flags( const char* path, int flags, mode_t mode, int folder )
{
    if ( counts( path ) && fails( OPEN ) )
    {
        errno = flags & O_CREAT ? ENOSPC : EIO;
        return -1;
    }
    return (int)syscall( SYS_openat, folder, path, flags, mode );
}

#define MODE_OF( flags, mode )                                                                                                   \
    mode_t mode = 0;                                                                                                             \
    if ( ( flags ) & ( O_CREAT | O_TMPFILE ) )                                                                                   \
    {                                                                                                                            \
        va_list list;                                                                                                            \
        va_start( list, flags );                                                                                                 \
        mode = va_arg( list, mode_t );                                                                                           \
        va_end( list );                                                                                                          \
    }

int open( const char* path, int flags, ... )
{
    MODE_OF( flags, mode )
    return open_flags( path, flags, mode, AT_FDCWD );
}

int open64( const char* path, int flags, ... )
{
    MODE_OF( flags, mode )
    return open_flags( path, flags, mode, AT_FDCWD );
}

int openat( int folder, const char* path, int flags, ... )
{
    MODE_OF( flags, mode )
    return open_flags( path, flags, mode, folder );
}

FILE* fopen( const char* path, const char* mode )
{
    NEXT( fopen );
    if ( counts( path ) && fails( OPEN ) )
    {
        errno = EIO;
        return NULL;
    }
    return s_next( path, mode );
}

FILE* fopen64( const char* path, const char* mode ) { return fopen( path, mode ); }

ssize_t write( int file, const void* bytes, size_t count )
{
    if ( file > 2 && fails( WRITE ) )
    {
        errno = ENOSPC;
        return -1;
    }
    return syscall( SYS_write, file, bytes, count );
}

ssize_t pwrite64( int file, const void* bytes, size_t count, off64_t at )
{
    if ( fails( WRITE ) )
    {
        errno = ENOSPC;
        return -1;
    }
    return syscall( SYS_pwrite64, file, bytes, count, at );
}

ssize_t pwrite( int file, const void* bytes, size_t count, off_t at ) { return pwrite64( file, bytes, count, at ); }

size_t fwrite( const void* bytes, size_t size, size_t count, FILE* file )
{
    NEXT( fwrite );
    if ( file != stdout && file != stderr && fails( WRITE ) )
    {
        errno = ENOSPC;
        return 0;
    }
    return s_next( bytes, size, count, file );
}

ssize_t read( int file, void* bytes, size_t count )
{
    if ( file > 2 && fails( READ ) )
    {
        errno = EIO;
        return -1;
    }
    return syscall( SYS_read, file, bytes, count );
}

size_t fread( void* bytes, size_t size, size_t count, FILE* file )
{
    NEXT( fread );
    if ( fails( READ ) )
    {
        errno = EIO;
        return 0;
    }
    return s_next( bytes, size, count, file );
}

int fsync( int file )
{
    if ( fails( FSYNC ) )
    {
        errno = EIO;
        return -1;
    }
    return (int)syscall( SYS_fsync, file );
}

int close( int file )
{
    int result = (int)syscall( SYS_close, file );
    if ( file > 2 && fails( CLOSE ) )
    {
        errno = EIO;
        return -1;
    }
    return result;
}

int fclose( FILE* file )
{
    NEXT( fclose );
    bool is_standard = file == stdout || file == stderr;
    int result = s_next( file );
    if ( !is_standard && fails( CLOSE ) )
    {
        errno = EIO;
        return EOF;
    }
    return result;
}

static int refuse( void )
{
    errno = EIO;
    return -1;
}

int rename( const char* from, const char* to )
{
    NEXT( rename );
    return fails( RENAME ) ? refuse() : s_next( from, to );
}

int renameat( int from_folder, const char* from, int to_folder, const char* to )
{
    return fails( RENAME ) ? refuse() : (int)syscall( SYS_renameat2, from_folder, from, to_folder, to, 0 );
}

static bool out_of_memory( void )
{
    if ( !fails( ALLOC ) )
        return false;
    errno = ENOMEM;
    return true;
}

extern void* __libc_malloc( size_t size );
extern void* __libc_calloc( size_t count, size_t size );
extern void* __libc_realloc( void* block, size_t size );
extern void* __libc_memalign( size_t alignment, size_t size );

void* malloc( size_t size ) { return out_of_memory() ? NULL : __libc_malloc( size ); }
void* calloc( size_t count, size_t size ) { return out_of_memory() ? NULL : __libc_calloc( count, size ); }
void* realloc( void* block, size_t size ) { return out_of_memory() ? NULL : __libc_realloc( block, size ); }
void* aligned_alloc( size_t alignment, size_t size ) { return out_of_memory() ? NULL : __libc_memalign( alignment, size ); }
void* memalign( size_t alignment, size_t size ) { return out_of_memory() ? NULL : __libc_memalign( alignment, size ); }

int posix_memalign( void** block, size_t alignment, size_t size )
{
    if ( out_of_memory() )
        return ENOMEM;
    *block = __libc_memalign( alignment, size );
    return *block != NULL ? 0 : ENOMEM;
}
