// Feeds the files of folders to a fuzz target, each once: its corpus, and what it found before.
//
//     fuzz_png FOLDER...
#include "fuzz/fuzz.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>

static int replay_file( const char* path )
{
    FILE* file = fopen( path, "rb" );
    fuzz_must( file != NULL && fseek( file, 0, SEEK_END ) == 0 );
    size_t size = (size_t)ftell( file );
    rewind( file );
    uint8_t* bytes = malloc( size > 0 ? size : 1 ); // of the very size: the sanitizer sees a byte too many
    fuzz_must( bytes != NULL && fread( bytes, 1, size, file ) == size );
    fclose( file );
    fprintf( stderr, "%s\n", path ); // the last line before a crash names its input
    (void)LLVMFuzzerTestOneInput( bytes, size );
    free( bytes );
    return 1;
}

static int replay_folder( const char* folder )
{
    struct dirent** entries;
    int found = scandir( folder, &entries, NULL, alphasort ), done = 0;
    for ( int i = 0; i < found; ++i )
    {
        char path[4096];
        snprintf( path, sizeof path, "%s/%s", folder, entries[i]->d_name );
        if ( entries[i]->d_name[0] != '.' )
            done += replay_file( path );
        free( entries[i] );
    }
    if ( found >= 0 )
        free( entries );
    return done;
}

int main( int argc, char** argv )
{
    int done = 0;
    for ( int i = 1; i < argc; ++i )
        done += replay_folder( argv[i] );
    printf( "%d files\n", done );
    return done > 0 ? 0 : 1;
}
