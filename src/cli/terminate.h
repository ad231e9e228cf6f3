// The end of the program by a library in C++ that cannot go on: Embree and TBB without memory.
#ifndef REFRAME_CLI_TERMINATE_H
#define REFRAME_CLI_TERMINATE_H

// From here on an exception that nothing catches ends the program with a line of ours and exit status 1, not with abort.
void rf_catch_terminate( void );

#endif
