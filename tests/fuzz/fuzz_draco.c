// A stream of Draco as the mesh of a .glb.
#include "fuzz/fuzz.h"
#include "gltf/gltf.h"

#include <stdio.h>
#include <string.h>

#define MOST 65536

// Attributes by the ids of the corpus, with the types that its meshes have and others.
static const char s_json[] =
    "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"mesh\":0}],\"scenes\":[{\"nodes\":[0]}],\"scene\":0,"
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1,\"TEXCOORD_0\":2,\"COLOR_0\":3},"
    "\"extensions\":{\"KHR_draco_mesh_compression\":{\"bufferView\":0,\"attributes\":{\"POSITION\":0,\"NORMAL\":1,"
    "\"TEXCOORD_0\":2,\"COLOR_0\":3}}}},{\"attributes\":{\"POSITION\":0},\"mode\":5,\"extensions\":{"
    "\"KHR_draco_mesh_compression\":{\"bufferView\":0,\"attributes\":{\"POSITION\":0}}}}]}],"
    "\"accessors\":[{\"componentType\":5126,\"count\":25,\"type\":\"VEC3\"},{\"componentType\":5126,\"count\":25,\"type\":"
    "\"VEC3\"},{\"componentType\":5126,\"count\":25,\"type\":\"VEC2\"},{\"componentType\":5121,\"normalized\":true,\"count\":25,"
    "\"type\":\"VEC4\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":%zu}],\"buffers\":[{\"byteLength\":%zu}]}";

int LLVMFuzzerTestOneInput( const uint8_t* data, size_t size )
{
    static uint8_t s_glb[sizeof s_json + 64 + MOST];
    RfError error = { 0 };
    RfScene scene;
    RfLog log = { 0 };
    if ( size == 0 || size > MOST )
        return 0;
    char json[sizeof s_json + 40];
    snprintf( json, sizeof json, s_json, size, size );
    size_t bytes = fuzz_glb( s_glb, json, data, size );
    fuzz_check( rf_load_gltf( fuzz_file( "input.glb", s_glb, bytes ), &scene, &log, &error ), &error );
    rf_destroy_scene( &scene );
    return 0;
}
