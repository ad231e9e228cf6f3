// scripts/blender/export.py on a scene made in Blender; skipped where Blender or the numpy
// that its exporter needs is missing.
#include "support/blender_run.h"

#include "gltf/gltf.h"
#include "light/sky.h"
#include "scene/camera.h"

// A camera that a moving parent and a constraint move, an area light, a point
// lamp, a world of one colour, a custom property.
static const char s_make[] =
    "import bpy, math, os\n"
    "bpy.ops.wm.read_factory_settings(use_empty=True)\n"
    "s = bpy.context.scene\n"
    "s.frame_start, s.frame_end = 1, 5\n"
    "bpy.ops.mesh.primitive_cube_add(size=1)\n"
    "cube = bpy.context.object\n"
    "m = bpy.data.materials.new('vase')\n"
    "m['reframe'] = {'bsdf': 'phong', 'diffuse': [0.2, 0.1, 0.05], 'specular': [0.5, 0.5, 0.5], 'exponent': 60}\n"
    "cube.data.materials.append(m)\n"
    "def lamp(kind, place, energy):\n"
    "    o = bpy.data.objects.new(kind, bpy.data.lights.new(kind, kind))\n"
    "    o.location = place\n"
    "    o.data.energy = energy\n"
    "    s.collection.objects.link(o)\n"
    "    return o\n"
    "area = lamp('AREA', (0, 0, 3), 100)\n"
    "area.data.shape, area.data.size, area.data.size_y = 'RECTANGLE', 2.0, 0.5\n"
    "lamp('POINT', (-2, -1, 2), 40).data.shadow_soft_size = 0.0\n"
    "w = bpy.data.worlds.new('w')\n"
    "s.world = w\n"
    "w.use_nodes = True\n"
    "b = w.node_tree.nodes['Background']\n"
    "b.inputs['Color'].default_value = (0.2, 0.4, 0.6, 1)\n"
    "b.inputs['Strength'].default_value = 0.5\n"
    "c = bpy.data.objects.new('Eye', bpy.data.cameras.new('Eye'))\n"
    "s.collection.objects.link(c)\n"
    "s.camera = c\n"
    "p = bpy.data.objects.new('pivot', None)\n"
    "p.hide_render = True\n" // what moves the camera need not be seen itself
    "s.collection.objects.link(p)\n"
    "c.parent, c.location = p, (0, -5, 0)\n"
    "t = c.constraints.new('TRACK_TO')\n"
    "at = bpy.data.objects.new('target', None)\n"
    "at.hide_render = True\n"
    "s.collection.objects.link(at)\n"
    "t.target, t.track_axis, t.up_axis = at, 'TRACK_NEGATIVE_Z', 'UP_Y'\n"
    "p.keyframe_insert('rotation_euler', frame=1)\n"
    "p.rotation_euler = (0, 0, math.pi / 2)\n"
    "p.keyframe_insert('rotation_euler', frame=5)\n"
    // a hidden cutter still cuts
    "bpy.ops.mesh.primitive_cylinder_add(radius=0.25, depth=3)\n"
    "cutter = bpy.context.object\n"
    "cutter.hide_render = True\n"
    "hole = cube.modifiers.new('hole', 'BOOLEAN')\n"
    "hole.object, hole.operation = cutter, 'DIFFERENCE'\n"
    "head = lamp('SPOT', (1, 0, 0), 4)\n"
    "head.parent = c\n"
    "bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath('t.blend'))\n";

static bool near( float a, double b ) { return fabs( (double)a - b ) <= 1e-4 * ( 1.0 + fabs( b ) ); }

// The power of a spot whose light does not fall off with the cosine, as Cycles' of Blender 3 does; of Blender's default cone. By the
// midpoint rule over the cosines.
static double spot_power( double watts )
{
    double least = cos( 0.125 * 3.14159265358979 ), edge = 0.15 * ( 1.0 - least ), with = 0.0, without = 0.0;
    for ( int i = 0; i < 20000; ++i )
    {
        double c = least + ( 1.0 - least ) * ( i + 0.5 ) / 20000.0, t = fmin( ( c - least ) / edge, 1.0 );
        with += c * t * t * ( 3.0 - 2.0 * t );
        without += t * t * ( 3.0 - 2.0 * t );
    }
    return watts * with / without;
}

static void check_scene( const RfScene* scene, bool is_4 )
{
    assert_int_equal( scene->camera_count, 1 );
    assert_string_equal( scene->cameras[0].name, "Eye" );
    assert_string_equal( scene->view.transform, is_4 ? "AgX" : "Filmic" );
    assert_true( scene->view.exposure == 0.0 && scene->view.gamma == 1.0 );
    RfCameraFrames frames;
    RfError error;
    assert_int_equal( rf_camera_frames( scene, scene->cameras, 24.0, &frames, &error ), RF_OK );
    assert_int_equal( frames.count, 5 );
    RfEye eye;
    assert_int_equal( rf_camera_eye( &( RfCameraSampling ){ scene, scene->cameras, NULL, { 24, 1 }, 64, 36 }, 4.0, &eye, &error ),
                      RF_OK );
    assert_true( near( eye.origin.x, 5 ) && near( eye.origin.y, 0 ) && near( eye.origin.z, 0 ) ); // a quarter turn on
    assert_true( near( eye.forward.x, -1 ) );
    assert_int_equal( scene->punctual_count, 2 );
    int points = 0, heads = 0;
    for ( int i = 0; i < scene->punctual_count; ++i )
    {
        const RfPunctual* p = scene->punctuals + i;
        points += near( p->intensity.x, 40.0 / ( 4.0 * 3.14159265358979 ) );
        // at the camera's right hand in the first frame
        heads += near( p->intensity.x, ( is_4 ? 4.0 : spot_power( 4.0 ) ) / ( 4.0 * 3.14159265358979 ) ) &&
                 near( p->position.x, 1 ) && near( p->position.z, 5 );
    }
    assert_true( points == 1 && heads == 1 );
    assert_true( scene->triangles.count > 60 ); // a cube, a hole of 32 sides in it, an area light
    assert_true( near( scene->environment.radiance.x, 0.1 ) && near( scene->environment.radiance.z, 0.3 ) );
    int glowing = 0, phong = 0;
    for ( uint32_t i = 0; i < scene->material_count; ++i )
    {
        const RfMaterial* m = scene->materials + i;
        phong += m->kind == RF_BSDF_PHONG && m->exponent == 60.0f;
        if ( m->emission.x == 0.0f )
            continue;
        ++glowing;
        assert_true( near( m->emission.x, 100.0 / ( is_4 ? 3.14159265358979 : 4.0 ) ) && !m->double_sided ); // of 1 m2
    }
    assert_true( glowing == 1 && phong == 1 );
    const RfTriangles* t = &scene->triangles;
    for ( uint32_t i = 0; i < t->count; ++i ) // the light looks down
    {
        if ( scene->materials[t->material[i]].emission.x > 0.0f )
            assert_true( t->normals[3 * (size_t)t->indices[3 * (size_t)i] + 1] < -0.99f );
    }
}

// A world of a packed picture, turned and dimmed; and what cannot be carried.
static const char s_make_world[] =
    "import bpy, math, numpy, os\n"
    "s = bpy.context.scene\n"
    "picture = bpy.data.images.new('sky', 64, 32, float_buffer=True)\n"
    "spaces = picture.colorspace_settings.bl_rna.properties['name'].enum_items.keys()\n"
    "picture.colorspace_settings.name = 'Linear' if 'Linear' in spaces else 'Linear Rec.709'\n"
    "p = numpy.ones((32, 64, 4), numpy.float32)\n"
    "p[:, :, 0] = 0.5\n"
    "p[24:, 8:11, :3] = (60, 50, 40)\n" // rows from below: a bright patch high up
    "picture.pixels.foreach_set(p.ravel())\n"
    "picture.pack()\n"
    "tree = s.world.node_tree\n"
    "new, link = tree.nodes.new, tree.links.new\n"
    "sky, turn, at = new('ShaderNodeTexEnvironment'), new('ShaderNodeMapping'), new('ShaderNodeTexCoord')\n"
    "sky.image = picture\n"
    "turn.inputs['Rotation'].default_value = (0, 0, math.radians(30))\n"
    "link(at.outputs['Generated'], turn.inputs[0])\n"
    "link(turn.outputs[0], sky.inputs[0])\n"
    "link(sky.outputs[0], tree.nodes['Background'].inputs['Color'])\n"
    "mix, white, path = new('ShaderNodeMixShader'), new('ShaderNodeBackground'), new('ShaderNodeLightPath')\n"
    "link(path.outputs['Is Camera Ray'], mix.inputs[0])\n" // white to the camera
    "link(tree.nodes['Background'].outputs[0], mix.inputs[1])\n"
    "link(white.outputs[0], mix.inputs[2])\n"
    "link(mix.outputs[0], tree.nodes['World Output'].inputs['Surface'])\n"
    "s.world.cycles_visibility.camera = False\n"
    "s.camera.data.clip_start = 4.8\n" // the cube's near side is at 4.5
    "s.camera.data.dof.use_dof = s.render.use_motion_blur = True\n"
    "if hasattr(s.eevee, 'use_motion_blur'):\n"
    "    s.eevee.use_motion_blur = True\n"
    "lamp = s.objects['POINT']\n"
    "lamp.data.keyframe_insert('energy', frame=1)\n"
    "lamp.data.energy = 80\n"
    "lamp.data.keyframe_insert('energy', frame=5)\n"
    "bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath('sky.blend'))\n";

// From azimuth and elevation in Blender's axes, degrees.
static RfVec3 sky_at( const RfScene* scene, double azimuth, double elevation )
{
    RfSky sky;
    RfError error;
    assert_int_equal( rf_make_sky( &scene->environment, &sky, &error ), RF_OK );
    double a = azimuth * 3.14159265358979 / 180.0, e = elevation * 3.14159265358979 / 180.0;
    RfVec3 way = rf_vec3( (float)( cos( a ) * cos( e ) ), (float)sin( e ), (float)( -sin( a ) * cos( e ) ) );
    RfVec3 radiance = rf_sky_radiance( &sky, way );
    rf_destroy_sky( &sky );
    return radiance;
}

static void check_world( const RfScene* scene )
{
    assert_int_equal( scene->environment.width, 64 );
    assert_int_equal( scene->environment.height, 32 );
    assert_true( scene->environment.hidden );
    // the patch's middle is 9.5 / 64 across: 126.6 degrees in the picture, 30 less once turned
    RfVec3 patch = sky_at( scene, 96.6, 67.5 ), before = sky_at( scene, 126.6, 67.5 ), mirrored = sky_at( scene, -96.6, 67.5 );
    assert_true( near( patch.x, 30.0 ) && near( patch.y, 25.0 ) && near( patch.z, 20.0 ) );
    assert_true( near( before.x, 0.25 ) && near( before.y, 0.5 ) );
    assert_true( near( mirrored.x, 0.25 ) && near( mirrored.y, 0.5 ) );
    RfVec3 below = sky_at( scene, 96.6, -67.5 );
    assert_true( near( below.x, 0.25 ) && near( below.z, 0.5 ) );
}

// Runs scripts in Blender, one after another, of which the last saves the scene.
static void make_by( const char* scripts )
{
    cli_write( "make.py", s_make, sizeof s_make - 1 );
    cli_write( "world.py", s_make_world, sizeof s_make_world - 1 );
    assert_int_equal( cli_run( BLENDER "--python-exit-code 9 %s > log 2>&1", scripts )->status, 0 );
}

BLENDER_TEST( test_export_keeps_the_scene )
{
    make_by( "-P make.py" );
    const CliResult* refused = blender_export( "t", "--camera Nobody" );
    assert_int_equal( refused->status, 1 );
    expect_said( refused->err, "no camera 'Nobody' in the scene: it has Eye" );
    cli_expect( cli_run( BLENDER "t.blend --python-expr 'import bpy; bpy.data.batch_remove(bpy.data.cameras)' -P " BLENDER_SCRIPT
                                 "none.glb > log 2> err; s=$?; grep blender-export: err >&2; exit $s" ),
                1, "no camera in the scene: add one" );
    assert_int_equal( blender_export( "t", "" )->status, 0 );
    AUTO_SCENE scene = convert_load( "t.glb" );
    check_scene( &scene, blender_is_4() );
    cli_expect( cli_run( BLENDER "t.blend --python-expr 'import sys; sys.modules[\"numpy\"] = None' -P " BLENDER_SCRIPT
                                 "t.glb > log "
                                 "2> err; s=$?; grep blender-export: err >&2; exit $s" ),
                1, "this Blender's Python has no numpy, which its glTF exporter needs: install it (Debian: python3-numpy)" );
    refused = blender_export( "t", "" );
    assert_int_equal( refused->status, 1 );
    expect_said( refused->err, "blender-export: t.glb: already exists: give another name or --overwrite" );
    assert_int_equal( blender_export( "t", "--overwrite" )->status, 0 );
}

// Blender's own: 50 mm, f/2.8, focused at 10 m, the shutter open for half a frame about each frame.
static void check_lens( const RfScene* scene )
{
    RfEye eye, before, after;
    int index;
    assert_int_equal( rf_find_camera( scene, NULL, &index, NULL ), RF_OK );
    const RfCamera* camera = scene->cameras + index;
    const RfCameraSampling sampling = { scene, camera, NULL, { 24, 1 }, 64, 36 };
    assert_int_equal( rf_camera_eye( &sampling, 1.0, &eye, NULL ), RF_OK );
    assert_float_equal( eye.lens_radius, 0.05 / 5.6, 1e-6 );
    assert_float_equal( eye.focus, 10.0, 1e-4 );
    assert_true( eye.moves );
    assert_int_equal( rf_camera_eye( &sampling, 0.75, &before, NULL ), RF_OK );
    assert_int_equal( rf_camera_eye( &sampling, 1.25, &after, NULL ), RF_OK );
    assert_memory_equal( &eye.open.origin, &before.origin, sizeof before.origin );
    assert_memory_equal( &eye.close.origin, &after.origin, sizeof after.origin );
}

BLENDER_TEST( test_world_becomes_the_environment )
{
    make_by( "-P make.py -P world.py" );
#define EXPORT_SKY BLENDER "sky.blend -P " BLENDER_SCRIPT
    cli_write( "a b-sky.exr", "", 0 ); // a map in the way
    const CliResult* done = cli_run( EXPORT_SKY "'a b.glb' > log" );
    assert_int_equal( done->status, 1 );
    expect_said( done->err, "a b-sky.exr: already exists" );
    done = cli_run( EXPORT_SKY "'a b.glb' --overwrite --accept-losses > log" );
    assert_int_equal( done->status, 0 );
    assert_null( strstr( done->err, "depth of field" ) );
    assert_null( strstr( done->err, "motion blur" ) );
    expect_said( done->err, "'Cube': nearer to 'Eye' than its clip start in frame 1: seen here" );
    expect_said( done->err, "looks different to the camera than to surfaces: taken as it lights the scene" );
    assert_null( strstr( done->err, "loss: 'POINT'" ) ); // its keys are carried
    RfScene scene = convert_load( "a b.glb" );
    check_world( &scene );
    check_lens( &scene );
    rf_destroy_scene( &scene );
    assert_int_equal( cli_run( EXPORT_SKY "one.glb --embed --accept-losses > log 2>&1" )->status, 0 );
    assert_false( cli_exists( "one-sky.exr" ) );
    scene = convert_load( "one.glb" );
    check_world( &scene );
    rf_destroy_scene( &scene );
}

// The picture is that of Cycles, but for noise at its edges: a camera that is half a pixel off, or a shape
// that is missing, differs by more.
static void expect_same_picture( const char* name, const char* cycles )
{
    Difference d = picture_difference( name, cycles, 1, 1 );
    assert_true( fabs( d.mean ) < 0.01 );
    assert_true( d.pixels < 0.06 );
}

// Frames 101 to 110 at 29.97 frames/s with two cuts by markers, of 64x36 pixels that are not square, by a zooming and shifted lens.
BLENDER_TEST( test_shot_is_blenders )
{
    blender_make( "shot --samples 64 shot" );
    const CliResult* done = blender_exported( "shot", "" );
    assert_null( strstr( done->err, "blender-export: " ) ); // nothing is lost
    done = cli_run( "$R info shot.glb" );
    expect_said( done->out, "Eye: 10 frames (101 to 110) at 29.97 frames/s, animated, 3 shots" );
    expect_said( done->out, "size       64x36" );
    done = cli_run( "$R render shot.glb -o f.####.exr --frames 101,110 --group 0 --tile 1 --spp 64 --filter box --quiet" );
    cli_expect( done, 0, NULL );
    expect_same_picture( "f.0101.exr", "shot-101.exr" );
    expect_same_picture( "f.0110.exr", "shot-110.exr" );
}

BLENDER_TEST( test_geometry_is_as_rendered )
{
    blender_make( "shot --samples 64 geometry" );
    const CliResult* done = blender_exported( "geometry", "2>&1" );
    expect_said( done->out, "'cutter': left out, as hidden in renders" );
    expect_said( done->out, "warning: 'hole in the picture': left out: holdouts do not exist in Reframe" );
    done = cli_run( "$R render geometry.glb -o g.exr --group 0 --tile 1 --spp 64 --filter box --quiet" );
    cli_expect( done, 0, NULL );
    expect_same_picture( "g.exr", "geometry-1.exr" );
}
