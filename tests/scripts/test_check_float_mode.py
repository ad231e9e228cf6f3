#!/usr/bin/env python3
"""tests/scripts/check-float-mode finds threads without the float mode, and takes those with it."""
import os
import subprocess
import sys
import tempfile
import unittest

CHECK = os.path.join(os.path.dirname(os.path.abspath(__file__)), "check-float-mode")
LOOP = """void f( int n )
{
#pragma omp parallel for num_threads( 2 ) schedule( dynamic, 1 )
    for ( int i = 0; i < n; ++i )
    {
        %s
        work( i );
    }
}
"""
REGION = """void f( int n )
{
#pragma omp parallel \\
    reduction( + : sum )
    {
        %s
#pragma omp for
        for ( int i = 0; i < n; ++i )
        {
            %s
            work( i );
        }
    }
}
"""
THREAD = """static void* run( void* user )
{
    %s
    return user;
}
bool start( pthread_t* thread ) { return pthread_create( thread, NULL, run, NULL ) == 0; }
"""
CALL = "rf_set_float_mode();"


def check(text):
    with tempfile.TemporaryDirectory() as top:
        os.makedirs(os.path.join(top, "src", "render"))
        with open(os.path.join(top, "src", "render", "a.c"), "w", encoding="utf-8") as file:
            file.write(text)
        run = subprocess.run([sys.executable, "-B", CHECK, top], stdout=subprocess.PIPE, text=True)
        return run.returncode, run.stdout


class FloatMode(unittest.TestCase):
    def good(self, text):
        status, output = check(text)
        self.assertEqual(status, 0, output)

    def bad(self, text, where):
        status, output = check(text)
        self.assertEqual((status, output.count("\n")), (1, 2), output)
        self.assertIn("a.c:%d: " % where, output)

    def test_with_it(self):
        for text in (LOOP % CALL, REGION % (CALL, ""), THREAD % CALL):
            self.good(text)

    def test_without_it(self):
        self.bad(LOOP % "", 3)
        self.bad(REGION % ("", ""), 3)
        self.bad(THREAD % "", 6)

    def test_a_loop_without_a_block(self):
        self.bad("void f( int n )\n{\n#pragma omp parallel for\n    for ( int i = 0; i < n; ++i )\n        work( i );\n"
                 "    {\n        rf_set_float_mode();\n    }\n}\n", 3)

    def test_only_some_of_the_threads(self):
        self.bad(REGION % ("", CALL), 3)
        self.bad(LOOP % "if ( i > 0 )\n        {\n            rf_set_float_mode();\n        }", 3)

    def test_a_comment_does_not_count(self):
        self.bad(LOOP % "// rf_set_float_mode();", 3)
        self.good("// #pragma omp parallel for\n#pragma omp simd\nint a;\n")


if __name__ == "__main__":
    unittest.main()
