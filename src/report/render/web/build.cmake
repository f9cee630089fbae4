# Bundles the viewers of reports: npm fetches what package-lock.json names into FOLDER, esbuild makes one file each of them. Where npm or
# what it fetches can't be had, it says so and the build goes on: reports then have tables and no charts.
#   cmake -DSOURCE=src/report/render/web -DFOLDER=build/.../web -DNPM=npm -P build.cmake
file(MAKE_DIRECTORY ${FOLDER})
function(without reason)
  message(WARNING "${reason}: reports will have tables but no charts. They are built by the next build that can.")
endfunction()
if(NOT NPM)
  without("npm is not installed")
  return()
endif()
# Fetching is repeated only where what is wanted has changed.
file(SHA256 ${SOURCE}/package-lock.json wanted)
set(fetched "")
if(EXISTS ${FOLDER}/fetched)
  file(READ ${FOLDER}/fetched fetched)
endif()
if(NOT fetched STREQUAL wanted)
  file(COPY ${SOURCE}/package.json ${SOURCE}/package-lock.json DESTINATION ${FOLDER})
  execute_process(COMMAND ${NPM} ci --ignore-scripts --no-audit --no-fund --fetch-retries=2 --fetch-timeout=60000
                  WORKING_DIRECTORY ${FOLDER} RESULT_VARIABLE result OUTPUT_VARIABLE said ERROR_VARIABLE said)
  if(result)
    without("npm could not fetch the packages of reports (${said})")
    return()
  endif()
  file(WRITE ${FOLDER}/fetched ${wanted})
endif()
# The sources lie beside node_modules so that imports are found there.
file(REMOVE_RECURSE ${FOLDER}/src)
file(COPY ${SOURCE}/src DESTINATION ${FOLDER})
file(GLOB viewers RELATIVE ${FOLDER}/src ${FOLDER}/src/report.js ${FOLDER}/src/view3d.js)
foreach(viewer IN LISTS viewers)
  string(REPLACE ".js" "" name ${viewer})
  execute_process(
    COMMAND ${NPM} exec --offline -- esbuild src/${viewer} --bundle --minify --format=iife --target=es2020 --charset=utf8
            --legal-comments=inline --outfile=${name}.js --log-level=warning
    WORKING_DIRECTORY ${FOLDER} RESULT_VARIABLE result ERROR_VARIABLE said)
  if(result)
    file(REMOVE ${FOLDER}/${name}.js ${FOLDER}/${name}.css)
    message(FATAL_ERROR "esbuild could not bundle ${viewer}:\n${said}")
  endif()
endforeach()
