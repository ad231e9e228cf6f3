// Interrupting render and resuming it as a user does.
#include "support/cli_run.h"
#include "support/test.h"

#include <jansson.h>
#include <signal.h>
#include <sys/stat.h>
#include <time.h>

#define FRAMES 8
#define TINY "--frames 1-8 --size 16x9 --spp 2 --group 0 --quiet "
// One thread: also a fast machine takes a moment for the frames after the first.
#ifdef REFRAME_SANITIZED // which is slow enough
#define SLOW "--frames 1-8 --size 48x27 --spp 8 --group 0 --threads 1 --quiet "
#else
#define SLOW "--frames 1-8 --size 48x27 --spp 48 --group 0 --threads 1 --quiet "
#endif

static double value_of( const json_t* json, const char* key ) { return json_number_value( json_object_get( json, key ) ); }

static bool is_true( const json_t* json, const char* key )
{
    assert_true( json_is_boolean( json_object_get( json, key ) ) );
    return json_is_true( json_object_get( json, key ) );
}

static size_t frame_count( const json_t* json ) { return json_array_size( json_object_get( json, "frames" ) ); }
static const json_t* frame_of( const json_t* json, size_t i ) { return json_array_get( json_object_get( json, "frames" ), i ); }

// A file's number in the file system, another one where it was replaced; 0: not there.
static uintmax_t inode_of( const char* name )
{
    struct stat status;
    return stat( cli_path( name ), &status ) == 0 ? (uintmax_t)status.st_ino : 0;
}

static void wait_for_another( const char* name, uintmax_t than )
{
    const struct timespec moment = { 0, 2000000 };
    for ( int i = 0; i < 300000 && ( inode_of( name ) == 0 || inode_of( name ) == than ); ++i )
        nanosleep( &moment, NULL );
}

// Interrupts what was started; how many frames it says to have kept.
static int interrupt( const char* goes_on )
{
    const CliResult* result = cli_wait( SIGINT );
    int kept = -1, all = -1;
    cli_expect( result, 130, goes_on );
    assert_int_equal( sscanf( result->err, "reframe render: interrupted: %d of %d frames", &kept, &all ), 2 );
    assert_int_equal( all, FRAMES );
    assert_true( kept >= 1 && kept < FRAMES );
    return kept;
}

// The frames of `json`, the first `kept` from the older JSON, which told of no others.
static void check_kept( const char* name, const char* older_name, int kept )
{
    json_t *json = cli_read_json( name ), *older = cli_read_json( older_name );
    assert_int_equal( frame_count( json ), FRAMES );
    assert_int_equal( frame_count( older ), kept );
    assert_int_equal( (int)value_of( json, "kept_frames" ), kept );
    assert_false( is_true( json, "interrupted" ) );
    for ( size_t i = 0; i < FRAMES; ++i )
    {
        const json_t *frame = frame_of( json, i ), *before = frame_of( older, i );
        assert_int_equal( (int)value_of( frame, "frame" ), i + 1 );
        assert_int_equal( is_true( frame, "kept" ), i < (size_t)kept );
        assert_true( value_of( frame, "native_spp" ) > 0.0 && value_of( frame, "effective_spp" ) > 0.0 &&
                     value_of( frame, "relmse_estimate" ) > 0.0 );
        if ( i >= (size_t)kept )
            continue;
        assert_true( value_of( frame, "seconds" ) > 0.0 && value_of( frame, "seconds" ) == value_of( before, "seconds" ) );
        assert_true( fabs( value_of( frame, "relmse_estimate" ) - value_of( before, "relmse_estimate" ) ) <=
                     1e-5 * value_of( before, "relmse_estimate" ) );
        assert_true( value_of( frame, "native_spp" ) == value_of( before, "native_spp" ) );
    }
    json_decref( json );
    json_decref( older );
}

static void check_interrupted_json( const char* name, int kept )
{
    json_auto_t* json = cli_read_json( name );
    assert_true( is_true( json, "interrupted" ) );
    assert_int_equal( frame_count( json ), kept );
    assert_int_equal( (int)value_of( json, "kept_frames" ), 0 );
    assert_true( value_of( json_object_get( json, "rays" ), "primary" ) > 0.0 );
    for ( size_t i = 0; i < (size_t)kept; ++i )
        assert_false( is_true( frame_of( json, i ), "kept" ) );
}

// How the threads of what was started wait: what its environment was when it began.
static void expect_wait_policy( const char* wanted )
{
    char command[256];
    snprintf( command, sizeof command, "cd '%s'; tr '\\0' '\\n' < /proc/$(cat pid)/environ | grep -qx '%s'", cli_folder(),
              wanted );
    assert_int_equal( system( command ), 0 );
}

TEST( test_interrupted_frames_stay_and_resume )
{
    cli_start( "echo $$ > pid; unset OMP_WAIT_POLICY; exec $R render $VASE -o i/f.####.exr --json i.json " SLOW );
    wait_for_another( "i/f.0001.exr", 0 );
    expect_wait_policy( "OMP_WAIT_POLICY=passive" );
    int kept = interrupt( "frames are finished and kept, --resume continues" );
    assert_int_equal( cli_count_files( ".exr", "i" ), kept );
    check_interrupted_json( "i.json", kept );
    cli_expect( cli_run( "cp i.json older.json; $R render $VASE -o i/f.####.exr --resume --json i.json " SLOW ), 0, NULL );
    check_kept( "i.json", "older.json", kept );
    cli_expect( cli_run( "$R render $VASE -o whole/f.####.exr " SLOW "&& for f in whole/*; do cmp $f i/${f#*/} || exit 1; done" ),
                0, NULL );
}

#ifdef REFRAME_SANITIZED
#define LIKE "--size 48x27 --spp 24 --group 3 --threads 2 "
#else
#define LIKE "--size 64x36 --spp 48 --group 3 --threads 2 "
#endif
#define GROUPED "--frames 1-4 " LIKE
#define GROUP "$R render $VASE -o w/f.####.exr --alpha --aov albedo,depth --quiet "

// Interrupts in the only group of all frames, after its first pass: nothing is finished, but the films are kept.
static void interrupt_group( const char* more, int signal_number )
{
    cli_expect( cli_run( "rm -f w.png" ), 0, NULL );
    cli_start( "exec " GROUP GROUPED "--preview w.png %s", more );
    wait_for_another( "w.png", 0 );
    cli_expect( cli_wait( signal_number ), 130,
                "interrupted: 0 of 4 frames are finished and kept, --resume continues from the films in w/f.0001.films" );
    assert_int_equal( cli_count_files( "", "w" ), 1 );
}

TEST( test_films_of_a_group_are_kept )
{
    interrupt_group( "", SIGINT );
    interrupt_group( "--resume", SIGTERM ); // and once more, in the midst of what was left
    cli_expect( cli_run( GROUP GROUPED ), 1, "w/f.0001.films: films of an interrupted render exist: --resume continues" );
    cli_expect( cli_run( GROUP GROUPED "--resume --seed 2" ), 1, "are the films of another render" );
    cli_expect( cli_run( GROUP "--frames 1-3 --size 64x36 --spp 8 --group 3 --resume" ), 1, "are the films of another render" );
    cli_expect( cli_run( "cp w/f.0001.films kept; head -c 100000 kept > w/f.0001.films; " GROUP GROUPED "--resume" ), 1,
                "w/f.0001.films: not a complete films file: add --overwrite" );
    cli_expect(
        cli_run(
            "cp kept w/f.0001.films; printf x | dd of=w/f.0001.films bs=1 seek=50000 conv=notrunc 2> /dev/null; " GROUP GROUPED
            "--resume" ),
        1, "w/f.0001.films: not a complete films file: add --overwrite" );
    cli_expect( cli_run( "cp kept w/f.0001.films" ), 0, NULL );
    cli_expect( cli_run( GROUP GROUPED "--resume" ), 0, NULL );
    assert_int_equal( cli_count_files( "", "w" ), 4 ); // the films are gone
    cli_expect( cli_run( "mv w resumed && " GROUP GROUPED "&& for f in w/*; do cmp $f resumed/${f#*/} || exit 1; done" ), 0,
                NULL );
}

// Films for other frames of the same render are named and not used; --overwrite starts over.
TEST( test_films_of_other_frames )
{
    cli_expect( cli_run( "rm -rf w w.png" ), 0, NULL );
    interrupt_group( "", SIGHUP );
    cli_expect( cli_run( GROUP "--frames 1-3 " LIKE "--resume" ), 0,
                "are films for frames 1 to 4 (4), and frames 1 to 3 (3) are left to be rendered: not used" );
    assert_int_equal( cli_count_files( "", "w" ), 3 );
    cli_expect( cli_run( "rm -rf w" ), 0, NULL );
    interrupt_group( "", SIGPIPE );
    cli_expect( cli_run( GROUP "--frames 1-2 --size 16x9 --spp 2 --group 0 --overwrite" ), 0, NULL );
    assert_int_equal( cli_count_files( "", "w" ), 2 );
}

#ifdef REFRAME_SANITIZED
#define KILLED "$R render $VASE -o q/f.####.exr --frames 1-6 --size 32x18 --spp 60 --group 2 --threads 2 --aov depth "
#else
#define KILLED "$R render $VASE -o q/f.####.exr --frames 1-6 --size 32x18 --spp 420 --group 2 --threads 2 --aov depth "
#endif

// A killed render goes on from the films it saved. Frames that were finished after that are made again, and no others.
TEST( test_killed_render_goes_on )
{
    static const char compare[] = "for f in killed/*; do cmp $f q/${f#*/} || exit 1; done";
    cli_expect( cli_run( "rm -rf q; " KILLED "--quiet && mv q killed" ), 0, NULL );
    cli_start( "exec " KILLED "--autosave 0.001s --quiet" );
    wait_for_another( "q/f.0001.films", 0 );
    assert_int_equal( cli_wait( SIGKILL )->status, 1000 + SIGKILL );
    cli_expect( cli_run( "cp q/f.0001.films films; " KILLED
                         "--resume --autosave 0 2> said && grep -q 'from the films of frame 1' said && %s",
                         compare ),
                0, NULL );
    assert_int_equal( cli_count_files( ".films", "q" ), 0 );
    cli_expect( cli_run( "cp films q/f.0001.films; rm q/f.000[3-6].exr; " KILLED
                         "--resume --json q.json 2> said && grep -q 'from the films of frame 1' said && %s",
                         compare ),
                0, NULL );
    assert_int_equal( cli_count_files( ".films", "q" ), 0 );
    json_auto_t* json = cli_read_json( "q.json" );
    assert_int_equal( (int)value_of( json, "kept_frames" ), 0 );
    cli_expect( cli_run( "cp films q/f.0001.films; " KILLED "--resume --quiet && ! test -e q/f.0001.films" ), 0,
                NULL ); // none are left
}

// A reader that is gone does not end the render before the films are kept; a hang-up that nohup ignores does not end it at all.
TEST( test_closed_pipes_and_hang_ups )
{
    const CliResult* result = cli_run(
        "mkfifo go; ( read x < go; $R render $VASE -o p/f.####.exr --frames 1-48 --size 48x27 --spp 64 --group 0 --tile 3x3 "
        "--threads 1 2>&1; "
        "echo $? > status ) | ( exec < /dev/null; echo > go ); until test -s status; do sleep 0.01; done; cat status" );
    assert_string_equal( result->out, "130\n" );
    char films[64];
    int finished = cli_count_files( ".exr", "p" ); // more than one where the program renders on before it writes its line
    snprintf( films, sizeof films, "p/f.%04d.films", finished + 1 );
    assert_true( finished >= 1 && finished < 48 && cli_exists( "p/f.0001.exr" ) && cli_exists( films ) );
    cli_start( "trap '' HUP; exec $R render $VASE -o h/f.####.exr " SLOW );
    wait_for_another( "h/f.0001.exr", 0 );
    cli_expect( cli_wait( SIGHUP ), 0, NULL );
}

// No room for the films: named, and what is finished stays.
TEST( test_films_that_cannot_be_kept )
{
    cli_expect( cli_run( "rm -rf w w.png" ), 0, NULL );
    cli_start( "ulimit -f 200; exec " GROUP GROUPED "--preview w.png" );
    wait_for_another( "w.png", 0 );
    cli_expect( cli_wait( SIGINT ), 130, "continues; without the films of those in work: w/f.0001.films: cannot be written" );
    assert_int_equal( cli_count_files( "", "w" ), 0 );
}

// Frames of another render lie behind those that are finished.
TEST( test_interrupted_overwrite_resumes )
{
    cli_expect( cli_run( "$R render $VASE -o o/f.####.exr --seed 2 --size 48x27 --frames 1-8 --spp 1 --group 0 --quiet" ), 0,
                NULL );
    cli_start(
        "echo $$ > pid; export OMP_WAIT_POLICY=active; exec $R render $VASE -o o/f.####.exr --overwrite --json o.json " SLOW );
    wait_for_another( "o/f.0001.exr", inode_of( "o/f.0001.exr" ) );
    expect_wait_policy( "OMP_WAIT_POLICY=active" );
    int kept = interrupt( "frames are finished and kept, --resume --overwrite continues" );
    check_interrupted_json( "o.json", kept );
    uintmax_t first = inode_of( "o/f.0001.exr" );
    cli_expect( cli_run( "$R render $VASE -o o/f.####.exr --resume " SLOW ), 1, "add --overwrite to replace such frames" );
    cli_expect( cli_run( "cp o.json older.json; $R render $VASE -o o/f.####.exr --resume --overwrite --json o.json " SLOW ), 0,
                NULL );
    check_kept( "o.json", "older.json", kept );
    assert_true( inode_of( "o/f.0001.exr" ) == first );
    cli_expect( cli_run( "for f in whole/*; do cmp $f o/${f#*/} || exit 1; done" ), 0, NULL );
}

TEST( test_interrupted_with_time_resumes )
{
    cli_start( "exec $R render $VASE -o t/f.####.exr --frames 1-8 --size 48x27 --time 0.3 --group 1 --json t.json --quiet" );
    wait_for_another( "t/f.0001.exr", 0 );
    int kept = interrupt( "--resume continues" );
    check_interrupted_json( "t.json", kept );
    uintmax_t first = inode_of( "t/f.0001.exr" );
    cli_expect(
        cli_run( "cp t.json older.json; $R render $VASE -o t/f.####.exr --frames 1-8 --size 48x27 --time 0.3 --group 1 --resume "
                 "--json t.json --quiet" ),
        0, NULL );
    check_kept( "t.json", "older.json", kept );
    assert_true( inode_of( "t/f.0001.exr" ) == first );
}

// Any kind of file in the way, in the midst of frames that fit.
TEST( test_resume_and_overwrite )
{
    cli_expect(
        cli_run( "$R render $VASE -o m/f.####.exr " TINY "&& cp -r m whole_m && echo text > m/f.0003.exr && rm m/f.0004.exr && "
                 "cp m/f.0001.exr m/f.0006.exr && $R render $VASE -o m/f.####.exr --frames 7 --overwrite --seed 9 --size 16x9 "
                 "--spp 2 --group 0 --quiet" ),
        0, NULL );
    uintmax_t second = inode_of( "m/f.0002.exr" );
    cli_expect( cli_run( "$R render $VASE -o m/f.####.exr --resume " TINY ), 1, "m/f.0003.exr" );
    const CliResult* result = cli_run( "$R render $VASE -o m/f.####.exr --resume --overwrite --json m.json " TINY );
    cli_expect( result, 0, NULL );
    assert_non_null( strstr( result->out, "4 frames in m/f.####.exr" ) );
    assert_non_null( strstr( result->out, "4 kept from before" ) );
    assert_true( inode_of( "m/f.0002.exr" ) == second );
    cli_expect( cli_run( "for f in whole_m/*; do cmp $f m/${f#*/} || exit 1; done" ), 0, NULL );
    json_auto_t* json = cli_read_json( "m.json" );
    static const bool kept[FRAMES] = { true, true, false, false, true, false, false, true };
    assert_int_equal( frame_count( json ), FRAMES );
    for ( size_t i = 0; i < FRAMES; ++i )
    {
        assert_int_equal( (int)value_of( frame_of( json, i ), "frame" ), i + 1 );
        assert_int_equal( is_true( frame_of( json, i ), "kept" ), kept[i] );
    }
    cli_expect( cli_run( "rm m/f.0005.exr && mkdir m/f.0005.exr && $R render $VASE -o m/f.####.exr --resume --overwrite " TINY ),
                1, "m/f.0005.exr: is a folder" );
}

static void expect_seconds( const char* name, bool known )
{
    json_auto_t* json = cli_read_json( name );
    assert_int_equal( frame_count( json ), FRAMES );
    for ( size_t i = 0; i < FRAMES; ++i )
    {
        assert_true( is_true( frame_of( json, i ), "kept" ) );
        assert_int_equal( json_is_number( json_object_get( frame_of( json, i ), "seconds" ) ), known );
        assert_true( value_of( frame_of( json, i ), "native_spp" ) == 2.0 );
    }
    assert_true( value_of( json_object_get( json, "rays" ), "primary" ) == 0.0 );
}

// The same command again, with all frames there, loses nothing.
TEST( test_resume_of_a_whole_sequence )
{
    cli_expect( cli_run( "$R render $VASE -o n/f.####.exr --json n.json " TINY "&& cp n.json n2.json && "
                         "$R render $VASE -o n/f.####.exr --resume --json n.json " TINY ),
                0, NULL );
    check_kept( "n.json", "n2.json", FRAMES );
    expect_seconds( "n.json", true );
    cli_expect( cli_run( "$R render $VASE -o n/f.####.exr --resume --json n.json " TINY ), 0, NULL ); // of kept frames too
    expect_seconds( "n.json", true );
    cli_expect( cli_run( "$R render $VASE -o n/f.####.exr --resume --json new.json " TINY ), 0, NULL );
    expect_seconds( "new.json", false );
    cli_expect( cli_run( "echo '{\"frames\": 3' > bad.json; $R render $VASE -o n/f.####.exr --resume --json bad.json " TINY ), 0,
                NULL );
    expect_seconds( "bad.json", false );
    // the times of files that have been replaced since
    cli_expect( cli_run( "$R render $VASE -o n/f.####.exr --overwrite --seed 5 " TINY
                         "&& $R render $VASE -o n/f.####.exr --resume --seed 5 "
                         "--json n.json " TINY ),
                0, NULL );
    expect_seconds( "n.json", false );
    const CliResult* result = cli_run( "$R render $VASE -o n/f.####.exr --resume --seed 5 --json - " TINY );
    cli_expect( result, 0, NULL );
    assert_non_null( strstr( result->out, "\"kept_frames\": 8" ) );
}

// What a killed render left goes with the one that finishes it; files in use stay, and those of others.
TEST( test_no_temporary_file_is_left )
{
    static const char make[] =
        "mkdir -p k && cd k && touch .reframe-99999-3.tmp .reframe-held-1.tmp "
        "reframe-1-1.tmp .reframe-1-2.tmp && touch -d '1 hour ago' .reframe-* && touch .reframe-1-9.tmp && "
        "touch -d tomorrow .reframe-1-9.tmp";
    cli_expect( cli_run( "%s", make ), 0, NULL );
    cli_expect( cli_run( "flock k/.reframe-1-2.tmp $R render $VASE -o k/f.####.exr --frames 1-2 --size 16x9 --spp 2 --group 0 "
                         "--quiet --resume" ),
                0, NULL );
    const CliResult* result = cli_run( "LC_ALL=C ls -A k" );
    assert_string_equal( result->out, ".reframe-1-2.tmp\n.reframe-1-9.tmp\n.reframe-held-1.tmp\nf.0001.exr\nf.0002.exr\n"
                                      "reframe-1-1.tmp\n" );
}

// What differs is named with both values.
TEST( test_resume_names_what_differs )
{
    static const char start[] = "reframe render: --resume: d/f.0002.exr: is of another render, of ";
    static const char* const cases[][2] = {
        { "--spp 4 --group 0 --tile 3x3 --size 16x9", "--spp 2 (here 4): give the same" },
        { "--spp 2 --group 0 --tile 3x3 --size 24x9 --seed 3", "--seed 1 (here 3), --size 16x9 (here 24x9): give the same" },
        { "--spp 2 --group 0 --tile 3x3 --size 16x9 --noise 0.5 --aov depth",
          "--noise 0 (here 0.5), --aov none (here depth): give" },
        { "--spp 2 --group 0 --size 16x9 --adaptive --tile 2x2", "--tile 3x3 (here 2x2), --adaptive off (here on): give" },
        { "--spp 2 --group 0 --tile 3x3 --size 16x9 --compression dwaa:30 --parts each --float",
          "--compression zip (here dwaa:30), --parts one (here each), --float no (here yes): give the same" },
        { "--spp 2 --group 0 --tile 3x3 --size 16x9 --fps 12", "frames in the path 48 (here 24): give the same" },
    };
    cli_expect( cli_run( "$R render $VASE -o d/f.####.exr --frames 2 --size 16x9 --spp 2 --group 0 --tile 3x3 --quiet" ), 0,
                NULL );
    for ( size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i )
    {
        const CliResult* result = cli_run( "$R render $VASE -o d/f.####.exr --frames 2 --quiet --resume %s", cases[i][0] );
        cli_expect( result, 1, cases[i][1] );
        assert_int_equal( strncmp( result->err, start, strlen( start ) ), 0 );
    }
    cli_expect( cli_run( "cp d/f.0002.exr d/f.0003.exr; $R render $VASE -o d/f.####.exr --frames 3 --quiet --resume --size 16x9 "
                         "--spp 2 --group 0 --tile 3x3" ),
                1, "is of another render, of frame 2 (here 3): give" );
    cli_write( "other.json", "", 0 );
    cli_expect(
        cli_run( "echo '{\"scene\":\"'$VASE'\",\"materials\":{\"vase\":{\"exponent\":9}}}' > other.json; "
                 "$R render other.json -o d/f.####.exr --frames 2 --quiet --resume --size 16x9 --spp 2 --group 0 --tile 3x3" ),
        1, "with these settings, but from another scene or camera path" );
}

// Off a terminal: a line for each frame, with the time spent, the estimate, and the samples, traced and effective.
TEST( test_a_line_for_each_frame )
{
    const CliResult* result = cli_run( "$R render $VASE -o l.exr --frames 3 --size 16x9 --spp 2 --group 0 --tile 3x3" );
    cli_expect( result, 0, "frame 1/1  number 3  " );
    const char* spent = strstr( result->err, " spent  " );
    assert_true( spent != NULL && strstr( spent, " (relMSE " ) != NULL );
    assert_true( spent[-3] == ':' ); // 0:00
    assert_non_null( strstr( spent, "  2 samples/pixel, 2 effective\n" ) );
}

// One group of all frames finishes them at once: its seconds are theirs in equal parts.
TEST( test_seconds_of_a_group_are_shared )
{
    cli_expect( cli_run( "$R render $VASE -o g/f.####.exr --frames 1-8 --size 64x36 --spp 48 --group 48 --quiet --json g.json" ),
                0, NULL );
    json_auto_t* json = cli_read_json( "g.json" );
    double sum = 0.0, most = 0.0;
    for ( size_t i = 0; i < FRAMES; ++i )
    {
        double seconds = value_of( frame_of( json, i ), "seconds" );
        sum += seconds;
        most = fmax( most, seconds );
    }
    assert_true( sum > 0.0 && sum <= value_of( json, "seconds" ) );
    if ( most > 0.4 * sum ) // the first had nearly all of it
        fail_msg( "a frame has %g of %g s", most, sum );
}

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )
