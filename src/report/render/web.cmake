# The viewers of reports, bundled from their npm packages into one file each. The program reads them when it writes a report, from
# the build folder or from the installed share folder.
set(web_source ${CMAKE_CURRENT_SOURCE_DIR}/report/render/web)
set(web_folder ${PROJECT_BINARY_DIR}/web)
find_program(NPM npm)
file(GLOB web_files CONFIGURE_DEPENDS ${web_source}/src/* ${web_source}/package*.json ${web_source}/build.cmake)
add_custom_command(
  OUTPUT ${web_folder}/report.js ${web_folder}/report.css ${web_folder}/view3d.js ${web_folder}/view3d.css
  COMMAND ${CMAKE_COMMAND} -DSOURCE=${web_source} -DFOLDER=${web_folder} -DNPM=${NPM} -P ${web_source}/build.cmake
  DEPENDS ${web_files}
  COMMENT "Bundling the viewers of reports")
add_custom_target(jaculus_web ALL DEPENDS ${web_folder}/report.js ${web_folder}/view3d.js)
install(DIRECTORY ${web_folder}/ DESTINATION ${CMAKE_INSTALL_DATADIR}/jaculus/web FILES_MATCHING PATTERN node_modules EXCLUDE
        PATTERN src EXCLUDE PATTERN "*.js" PATTERN "*.css")
install(FILES ${CMAKE_CURRENT_SOURCE_DIR}/report/render/figures.py DESTINATION ${CMAKE_INSTALL_DATADIR}/jaculus)
