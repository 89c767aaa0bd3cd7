# Rules of `cmake --install`: the static libraries, the public headers, and files for find_package and pkg-config.
#
#   find_package(lockstone 0.1 CONFIG REQUIRED)                    the engine, sessions and replays: lockstone::lockstone
#   find_package(lockstone 0.1 CONFIG REQUIRED COMPONENTS net)     UDP, encryption and the relay, too: lockstone::net
#   pkg-config --static --cflags --libs lockstone
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(LOCKSTONE_LAYERS base math state shapes collide solve model scene play tick world prove session replay)
if(TARGET lockstone_net)
    list(APPEND LOCKSTONE_LAYERS net)
endif()
set(LOCKSTONE_INSTALLED lockstone lockstone_options)
foreach(LAYER ${LOCKSTONE_LAYERS})
    list(APPEND LOCKSTONE_INSTALLED lockstone_${LAYER})
    # In the exported file a layer has the name lockstone::LAYER.
    set_target_properties(lockstone_${LAYER} PROPERTIES EXPORT_NAME ${LAYER})
endforeach()
set_target_properties(lockstone_options PROPERTIES EXPORT_NAME options)

install(TARGETS ${LOCKSTONE_INSTALLED} EXPORT lockstone-targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/lockstone DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(DIRECTORY ${PROJECT_SOURCE_DIR}/replay DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.h"
    PATTERN parser.h EXCLUDE PATTERN codec.h EXCLUDE PATTERN pack.h EXCLUDE) # these three are internal
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})

set(LOCKSTONE_PACKAGE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/lockstone)
install(EXPORT lockstone-targets NAMESPACE lockstone:: DESTINATION ${LOCKSTONE_PACKAGE_DIR})
configure_package_config_file(${PROJECT_SOURCE_DIR}/tools/install/lockstone-config.cmake.in
    ${PROJECT_BINARY_DIR}/lockstone-config.cmake INSTALL_DESTINATION ${LOCKSTONE_PACKAGE_DIR} NO_SET_AND_CHECK_MACRO)
# Both sides of a match need the same bits, so another minor version does not satisfy a request before 1.0.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/lockstone-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/lockstone-config.cmake ${PROJECT_BINARY_DIR}/lockstone-config-version.cmake
    DESTINATION ${LOCKSTONE_PACKAGE_DIR})

# The linker needs a library before those that it uses, so the list runs from the highest layer down.
set(LOCKSTONE_PC_LIBS)
foreach(LAYER ${LOCKSTONE_LAYERS})
    if(NOT LAYER STREQUAL net)
        list(PREPEND LOCKSTONE_PC_LIBS -llockstone_${LAYER})
    endif()
endforeach()
list(JOIN LOCKSTONE_PC_LIBS " " LOCKSTONE_PC_LIBS)
configure_file(${PROJECT_SOURCE_DIR}/tools/install/lockstone.pc.in ${PROJECT_BINARY_DIR}/lockstone.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/lockstone.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
