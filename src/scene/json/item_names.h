// What objects of a glTF document are called: by their names, or "materials[3]".
#ifndef REFRAME_SCENE_JSON_ITEM_NAMES_H
#define REFRAME_SCENE_JSON_ITEM_NAMES_H

#include "base/json.h"

#define RF_ITEM_NAME 32 // of one without a name

// The name of an item of a list that is called `plural`, as in the reader of glTF.
const char* rf_item_name( const json_t* list, const char* plural, size_t index, char fallback[RF_ITEM_NAME] );

// Fails since no item of the list, such as a "material" of "materials", has the name; says which there are.
RfResult rf_fail_unknown_item( const RfField* field, const char* kind, const char* name, const json_t* list );

#endif
