// Boxes around what moves: no ray that meets one is left out, and hardly any other is kept.
#include "support/test.h"
#include "base/random.h"
#include "scene/scene.h"
#include "trace/boxes.h"

#define BLOCKS 200

static float number( uint32_t dimension, int i )
{
    return 2.0f * rf_random( rf_pixel_key( rf_pass_key( 5, 0, 0, 0 ), (uint32_t)i ), dimension ) - 1.0f;
}

// In doubles, whether o + t d, 0 < t < length, meets a box that is wider by a margin.
static bool meets( const float low[3], const float high[3], double margin, const float o[3], const float d[3], double length )
{
    double near = 0.0, far = length;
    for ( int c = 0; c < 3; ++c )
    {
        double a = (double)low[c] - margin - (double)o[c], b = (double)high[c] + margin - (double)o[c], way = (double)d[c];
        if ( way == 0.0 && ( a > 0.0 || b < 0.0 ) )
            return false;
        if ( way == 0.0 )
            continue;
        near = fmax( near, fmin( a / way, b / way ) );
        far = fmin( far, fmax( a / way, b / way ) );
    }
    return near <= far;
}

static bool meets_any( const RfBoxes* boxes, double margin, const float o[3], const float d[3], double length )
{
    bool any = false;
    for ( int b = 0; b < boxes->count; ++b )
        any = any || meets( boxes->low[b], boxes->high[b], margin, o, d, length );
    return any;
}

// Two boxes, of which the second is a point, in a world of a size.
static RfBoxes make_boxes( float size )
{
    RfBoxes boxes = rf_no_boxes();
    for ( int c = 0; c < 3; ++c )
    {
        boxes.low[1][c] = size * ( 0.2f + 0.1f * (float)c );
        boxes.high[1][c] = boxes.low[1][c] + 0.15f * size;
        boxes.low[3][c] = boxes.high[3][c] = -0.5f * size;
    }
    rf_finish_boxes( &boxes );
    assert_int_equal( boxes.count, 2 );
    return boxes;
}

static void try_rays( float size, float length )
{
    RfBoxes boxes = make_boxes( size );
    double inside = (double)boxes.high[0][0] - (double)boxes.low[0][0];
    assert_true( inside > 0.15 * (double)size && inside < 0.1501 * (double)size ); // the margin is small
    int kept = 0, met = 0;
    for ( int block = 0; block < BLOCKS; ++block )
    {
        float o[3][RF_BOX_BLOCK], d[3][RF_BOX_BLOCK];
        uint8_t touched[RF_BOX_BLOCK];
        int32_t near[RF_BOX_BLOCK + 1];
        int count = RF_BOX_BLOCK - block % 37;
        for ( int i = 0; i < count; ++i )
        {
            for ( int c = 0; c < 3; ++c )
            {
                uint32_t axis = (uint32_t)c;
                int at = block * RF_BOX_BLOCK + i;
                o[c][i] = size * number( axis, at );
                d[c][i] = ( length < INFINITY ? size : 1.0f ) * ( i % 3 == 0 && c != block % 3 ? 0.0f : number( 3 + axis, at ) );
            }
            touched[i] = i % 5 == 0;
        }
        const float *from[3] = { o[0], o[1], o[2] }, *way[3] = { d[0], d[1], d[2] };
        int listed = rf_list_near_rays( &boxes, count, from, way, length, touched, near ), at = 0;
        for ( int i = 0; i < count; ++i )
        {
            const float a[3] = { o[0][i], o[1][i], o[2][i] }, b[3] = { d[0][i], d[1][i], d[2][i] };
            bool found = at < listed && near[at] == i;
            at += found;
            if ( touched[i] )
            {
                assert_false( found );
                continue;
            }
            assert_true( found || !meets_any( &boxes, 0.0, a, b, (double)length ) );
            assert_true( !found || meets_any( &boxes, 1e-3 * (double)size, a, b, (double)length * 1.001 ) );
            met += meets_any( &boxes, 0.0, a, b, (double)length );
            kept += found;
        }
        assert_int_equal( at, listed );
    }
    assert_true( met > 100 && kept < met + met / 50 + 5 );
}

TEST( test_rays_that_meet_are_kept )
{
    for ( int exponent = -12; exponent <= 12; exponent += 6 )
    {
        try_rays( powf( 10.0f, (float)exponent ), 1.0f );
        try_rays( powf( 10.0f, (float)exponent ), INFINITY );
    }
}

// Packets: rays that are not valid are not near, and what ends before a box does not meet it.
TEST( test_lanes_of_a_packet )
{
    RfBoxes boxes = make_boxes( 1.0f );
    float x[16], y[16], z[16], across[16] = { 0.0f }, down[16], far[16];
    int valid[16], near[16];
    const float *o[3] = { x, y, z }, *d[3] = { across, across, down };
    for ( int i = 0; i < 16; ++i )
    {
        x[i] = 0.25f;
        y[i] = 0.35f;
        z[i] = 10.0f;
        down[i] = i == 3 ? 1.0f : -1.0f;
        far[i] = i == 5 ? 9.0f : i == 6 ? -INFINITY : i == 7 ? 9.6f : INFINITY;
        valid[i] = i == 9 || i == 6 ? 0 : -1;
    }
    assert_true( rf_find_near_lanes( &boxes, o, d, far, valid, near ) );
    for ( int i = 0; i < 16; ++i )
        assert_int_equal( near[i], i == 3 || i == 5 || i == 6 || i == 9 ? 0 : -1 );
    for ( int i = 0; i < 16; ++i )
        x[i] = 3.0f;
    assert_false( rf_find_near_lanes( &boxes, o, d, far, valid, near ) );
    RfBoxes none = rf_no_boxes();
    rf_finish_boxes( &none );
    assert_int_equal( none.count, 0 );
    assert_false( rf_find_near_lanes( &none, o, d, far, valid, near ) );
}
