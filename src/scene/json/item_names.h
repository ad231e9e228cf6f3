// What objects of a glTF document are called, by their names or "materials[3]", and edits of them by that.
#ifndef REFRAME_SCENE_JSON_ITEM_NAMES_H
#define REFRAME_SCENE_JSON_ITEM_NAMES_H

#include "base/json.h"

#define RF_ITEM_NAME 32 // of one without a name

// The name of an item of a list that is called `plural`, as in the reader of glTF.
const char* rf_item_name( const json_t* list, const char* plural, size_t index, char fallback[RF_ITEM_NAME] );

// Fails since no item of the list, such as a "material" of "materials", has the name; says which there are.
RfResult rf_fail_unknown_item( const RfField* field, const char* kind, const char* name, const json_t* list );

// Edits the items of a list, such as a "material", that `edits` has a member for by their names, each of which has some of `keys`.
// Fails where nothing has the name.
typedef RfResult RfEditItem( const RfField* edit, json_t* item, size_t index, void* user );
RfResult rf_edit_items( const RfField* edits, const char* kind, const json_t* list, const char* const* keys, RfEditItem* run,
                        void* user );

// The member of that name, an object that is made if missing; NULL if out of memory.
json_t* rf_edit_member( json_t* object, const char* key );

#endif
