#include "base/file.h"
#include "import/assimp_import.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define IMAGE_LIMIT ( 1ull << 30 )

static const char* mime_of( const uint8_t* bytes, size_t size )
{
    static const uint8_t png[8] = { 0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n' };
    if ( size > sizeof png && memcmp( bytes, png, sizeof png ) == 0 )
        return "image/png";
    return size > 3 && bytes[0] == 0xff && bytes[1] == 0xd8 && bytes[2] == 0xff ? "image/jpeg" : NULL;
}

static const char* file_name_of( const char* name )
{
    const char* slash = strrchr( name, '/' );
    return slash != NULL ? slash + 1 : name;
}

// Reads an embedded image: "*3", or by its original name.
static bool read_embedded( RfImport* import, const char* name, uint8_t** bytes, size_t* size )
{
    const struct aiScene* scene = import->scene;
    for ( unsigned i = 0; i < scene->mNumTextures; ++i )
    {
        const struct aiTexture* texture = scene->mTextures[i];
        char star[16], own[1024];
        snprintf( star, sizeof star, "*%u", i );
        snprintf( own, sizeof own, "%s", texture->mFilename.data );
        for ( char* c = own; *c != 0; ++c )
            *c = *c == '\\' ? '/' : *c;
        if ( texture->mHeight != 0 || texture->mWidth == 0 ||
             ( strcmp( name, star ) != 0 && strcmp( file_name_of( name ), file_name_of( own ) ) != 0 ) )
            continue;
        *size = texture->mWidth;
        *bytes = malloc( *size );
        if ( *bytes != NULL )
            memcpy( *bytes, texture->pcData, *size );
        return *bytes != NULL;
    }
    return false;
}

// Reads an image by its name, relative to the folder of the file; else, as paths often belong
// to the machine on which the file was made, by its last component beside the file.
static bool read_beside( RfImport* import, const char* name, uint8_t** bytes, size_t* size )
{
    char path[8192];
    int folder = (int)( file_name_of( import->path ) - import->path );
    snprintf( path, sizeof path, "%.*s%s", *name == '/' ? 0 : folder, import->path, name );
    if ( rf_read_file( path, IMAGE_LIMIT, bytes, size, NULL ) == RF_OK )
        return true;
    snprintf( path, sizeof path, "%.*s%s", folder, import->path, file_name_of( name ) );
    return rf_read_file( path, IMAGE_LIMIT, bytes, size, NULL ) == RF_OK;
}

static bool make_room( RfImport* import )
{
    RfModel* model = import->model;
    if ( model->image_count < import->image_room )
        return true;
    int room = import->image_room > 0 ? 2 * import->image_room : 16;
    RfModelImage* images = realloc( model->images, (size_t)room * sizeof *images );
    if ( images == NULL )
        return false;
    model->images = images;
    char( *names )[1024] = realloc( import->image_names, (size_t)room * sizeof *names );
    if ( names == NULL )
        return false;
    import->image_names = names;
    import->image_room = room;
    return true;
}

int rf_import_image( RfImport* import, const char* given )
{
    RfModel* model = import->model;
    char name[1024];
    snprintf( name, sizeof name, "%s", given );
    for ( char* c = name; *c != 0; ++c )
        *c = *c == '\\' ? '/' : *c;
    for ( int i = 0; i < model->image_count; ++i )
    {
        if ( strcmp( import->image_names[i], name ) == 0 )
            return i;
    }
    uint8_t* bytes = NULL;
    size_t size = 0;
    if ( !read_embedded( import, name, &bytes, &size ) && !read_beside( import, name, &bytes, &size ) )
    {
        rf_warn( import->log, "texture '%s': cannot be read: it is left out: put it beside the file", name );
        return -1;
    }
    const char* mime = mime_of( bytes, size );
    if ( mime == NULL || !make_room( import ) )
    {
        if ( mime == NULL )
            rf_warn( import->log, "texture '%s': is neither PNG nor JPEG: it is left out: convert it and rename it", name );
        free( bytes );
        return -1;
    }
    snprintf( import->image_names[model->image_count], sizeof name, "%s", name );
    model->images[model->image_count] =
        ( RfModelImage ){ .name = strdup( file_name_of( name ) ), .mime = mime, .bytes = bytes, .size = size };
    return model->image_count++;
}
