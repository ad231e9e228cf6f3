// A view of meshoptimizer in a .glb: four bytes say mode, filter, stride and count, the others are the stream.
#include "fuzz/fuzz.h"
#include "gltf/gltf.h"

#include <stdio.h>
#include <string.h>

#define MOST 65536

static const char s_json[] =
    "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"mesh\":0}],\"scenes\":[{\"nodes\":[0]}],\"scene\":0,"
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":%d%s},\"indices\":%d}]}],"
    "\"accessors\":[{\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"},{\"bufferView\":0,\"componentType\":%s}],"
    "\"bufferViews\":[{\"buffer\":1,\"byteLength\":%d,\"extensions\":{\"KHR_meshopt_compression\":{\"buffer\":0,\"byteLength\":%"
    "zu,"
    "\"byteStride\":%d,\"count\":%d,\"mode\":\"%s\",\"filter\":\"%s\"}}}],"
    "\"buffers\":[{\"byteLength\":%zu},{\"byteLength\":1,\"extensions\":{\"KHR_meshopt_compression\":{\"fallback\":true}}}]}";

static const char* const s_modes[] = { "ATTRIBUTES", "TRIANGLES", "INDICES" };
static const char* const s_filters[] = { "NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL", "COLOR" };

// Indices of a triangle of zeros, positions, colours of its three corners: by what a stride may be.
static void write_json( const uint8_t head[4], size_t size, char* json, size_t room )
{
    int mode = head[0] % 3, filter = mode == 0 ? head[1] % 5 : 0, stride = mode > 0 ? 2 + head[2] % 2 * 2 : 4 + head[2] % 64 * 4;
    int count = head[3] + 1;
    char type[96];
    if ( mode > 0 )
        snprintf( type, sizeof type, "%d,\"count\":%d,\"type\":\"SCALAR\"", stride == 2 ? 5123 : 5125, count );
    else if ( stride == 12 )
        snprintf( type, sizeof type, "5126,\"count\":%d,\"type\":\"VEC3\"", count );
    else
        snprintf( type, sizeof type, "5121,\"normalized\":true,\"count\":%d,\"type\":\"VEC4\"", stride * count / 4 );
    bool positions = mode == 0 && stride == 12;
    snprintf( json, room, s_json, positions ? 1 : 0, mode == 0 && !positions ? ",\"COLOR_0\":1" : "", mode > 0 ? 1 : 7, type,
              stride * count, size, stride, count, s_modes[mode], s_filters[filter], size );
    if ( mode == 0 ) // no indices
        memset( strstr( json, ",\"indices\":7" ), ' ', 12 );
}

int LLVMFuzzerTestOneInput( const uint8_t* data, size_t size )
{
    static uint8_t s_glb[sizeof s_json + 512 + MOST];
    RfError error = { 0 };
    RfScene scene;
    RfLog log = { 0 };
    char json[sizeof s_json + 256];
    if ( size < 5 || size > MOST )
        return 0;
    write_json( data, size - 4, json, sizeof json );
    size_t bytes = fuzz_glb( s_glb, json, data + 4, size - 4 );
    fuzz_check( rf_load_gltf( fuzz_file( "input.glb", s_glb, bytes ), &scene, &log, &error ), &error );
    rf_destroy_scene( &scene );
    return 0;
}
