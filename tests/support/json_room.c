#include "support/json_room.h"

#include "support/cli_run.h"

#include <stdio.h>
#include <string.h>

// A triangle of vase before a still and a moving camera; materials of each kind.
static const char s_gltf[] =
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1,2]%s}],"
    "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":0.8,\"znear\":0.1}}],"
    "\"nodes\":[{\"name\":\"Eye\",\"camera\":0},{\"name\":\"Side\",\"camera\":0,\"translation\":[1,0,0]},{\"mesh\":0}],"
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"material\":2}]}],"
    "\"materials\":[{\"name\":\"vase\",\"extras\":{\"reframe\":{\"bsdf\":\"phong\",\"diffuse\":[0.2,0.1,0.1],"
    "\"specular\":[0.5,0.5,0.5],\"exponent\":60}}},"
    "{\"name\":\"wood floor\",\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.5,0.25,0.125,1],\"metallicFactor\":0},"
    "\"extensions\":{\"KHR_materials_specular\":{\"specularFactor\":0}}},"
    "{\"name\":\"lamp\",\"emissiveFactor\":[1,1,1]},{},{\"name\":\"lamp\",\"emissiveFactor\":[0,1,0]}],"
    "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\","
    "\"min\":[-1,-1,-2],\"max\":[1,1,-2]}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],"
    "\"buffers\":[{\"byteLength\":36,\"uri\":\"data:application/octet-stream;base64,"
    "AACAvwAAgL8AAADAAACAPwAAgL8AAADAAAAAAAAAgD8AAADA\"}]}";

void write_text( const char* name, const char* text ) { cli_write( name, text, strlen( text ) ); }

void write_room( const char* extras )
{
    char text[4096];
    snprintf( text, sizeof text, s_gltf, extras );
    write_text( "room.gltf", text );
}

RfResult load_named( const char* name, RfScene* scene, RfError* error )
{
    char path[256];
    snprintf( path, sizeof path, "%s/%s", cli_folder(), name );
    return rf_load_scene( path, scene, NULL, error );
}

RfResult try_members( const char* members, RfScene* scene, RfError* error )
{
    char text[4096];
    snprintf( text, sizeof text, "{\"scene\":\"room.gltf\"%s%s}", members[0] != 0 ? "," : "", members );
    write_text( "scene.json", text );
    return load_named( "scene.json", scene, error );
}
