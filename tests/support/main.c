// Of test programs that have no main() of their own: a file of the library by itself, so that those that have one link without it.
#include "support/test.h"

int main( void ) { return run_listed_tests(); }
