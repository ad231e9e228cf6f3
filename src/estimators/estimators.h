// The list of estimators.
#ifndef REFRAME_ESTIMATORS_ESTIMATORS_H
#define REFRAME_ESTIMATORS_ESTIMATORS_H

// X( name, what it does ): the table is rf_<name>_estimator. The first is the default.
#define RF_ESTIMATOR_LIST( X )                                                                                                   \
    X( reuse, "share paths in groups and tiles" )                                                                                \
    X( gradient, "gradient-domain path reusing in tiles, no groups" )

// Their names, as users write them, in the order of the list, with NULL at the end.
extern const char* const rf_estimator_words[];

#endif
