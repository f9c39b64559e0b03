# find_package(bdtree CONFIG) gives bdtree::bdtree, the shared library, and bdtree::static.
get_filename_component(_bdtree_prefix "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)

if(NOT TARGET bdtree::bdtree)
    add_library(bdtree::bdtree SHARED IMPORTED)
    set_target_properties(bdtree::bdtree PROPERTIES
        IMPORTED_LOCATION "${_bdtree_prefix}/lib/libbdtree.so"
        IMPORTED_SONAME "libbdtree.so.0.1"
        INTERFACE_INCLUDE_DIRECTORIES "${_bdtree_prefix}/include")
endif()

if(NOT TARGET bdtree::static)
    add_library(bdtree::static STATIC IMPORTED)
    set_target_properties(bdtree::static PROPERTIES
        IMPORTED_LOCATION "${_bdtree_prefix}/lib/libbdtree.a"
        INTERFACE_LINK_LIBRARIES "pthread;dl;m"
        INTERFACE_INCLUDE_DIRECTORIES "${_bdtree_prefix}/include")
endif()

unset(_bdtree_prefix)
