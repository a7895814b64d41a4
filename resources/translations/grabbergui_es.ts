<?xml version="1.0" encoding="utf-8"?>
<!DOCTYPE TS>
<TS version="2.1">
<context>
    <name>AcquisitionController</name>
    <message>
        <source>there is no frame to save yet; start the camera first</source>
        <translation>todavía no hay imagen que capturar; inicie antes la cámara</translation>
    </message>
    <message>
        <source>Saved {0}</source>
        <translation>Guardado {0}</translation>
    </message>
</context>
<context>
    <name>AutoButton</name>
    <message>
        <source>Auto</source>
        <translation>Autom.</translation>
    </message>
    <message>
        <source>Once</source>
        <translation>Una vez</translation>
    </message>
    <message>
        <source>{0}
It {1}.</source>
        <translation>{0}
({1}.)</translation>
    </message>
</context>
<context>
    <name>Calibrating</name>
    <message>
        <source>no board is seen</source>
        <translation>no se ve ningún tablero</translation>
    </message>
    <message>
        <source>hold it still</source>
        <translation>manténgalo quieto</translation>
    </message>
    <message>
        <source>this view is there already</source>
        <translation>esta vista ya está</translation>
    </message>
    <message>
        <source>kept</source>
        <translation>guardada</translation>
    </message>
    <message>
        <source>Everything is covered</source>
        <translation>Todo está cubierto</translation>
    </message>
    <message>
        <source>Next: tilt it, its left edge nearer</source>
        <translation>Ahora: inclínelo, con el borde izquierdo más cerca</translation>
    </message>
    <message>
        <source>Next: tilt it, its right edge nearer</source>
        <translation>Ahora: inclínelo, con el borde derecho más cerca</translation>
    </message>
    <message>
        <source>Next: tilt it, its upper edge nearer</source>
        <translation>Ahora: inclínelo, con el borde superior más cerca</translation>
    </message>
    <message>
        <source>Next: tilt it, its lower edge nearer</source>
        <translation>Ahora: inclínelo, con el borde inferior más cerca</translation>
    </message>
    <message>
        <source>Next: hold it at the top left</source>
        <translation>Ahora: arriba a la izquierda</translation>
    </message>
    <message>
        <source>Next: hold it at the top</source>
        <translation>Ahora: arriba</translation>
    </message>
    <message>
        <source>Next: hold it at the top right</source>
        <translation>Ahora: arriba a la derecha</translation>
    </message>
    <message>
        <source>Next: hold it at the left</source>
        <translation>Ahora: a la izquierda</translation>
    </message>
    <message>
        <source>Next: hold it in the middle</source>
        <translation>Ahora: en el centro</translation>
    </message>
    <message>
        <source>Next: hold it at the right</source>
        <translation>Ahora: a la derecha</translation>
    </message>
    <message>
        <source>Next: hold it at the bottom left</source>
        <translation>Ahora: abajo a la izquierda</translation>
    </message>
    <message>
        <source>Next: hold it at the bottom</source>
        <translation>Ahora: abajo</translation>
    </message>
    <message>
        <source>Next: hold it at the bottom right</source>
        <translation>Ahora: abajo a la derecha</translation>
    </message>
    <message>
        <source>Next: hold it nearer</source>
        <translation>Ahora: más cerca</translation>
    </message>
    <message>
        <source>Next: hold it farther away</source>
        <translation>Ahora: más lejos</translation>
    </message>
    <message>
        <source>there is no calibration to save yet</source>
        <translation>todavía no hay ninguna calibración que guardar</translation>
    </message>
    <message>
        <source>the calibration could not be saved: {0}</source>
        <translation>no se pudo guardar la calibración: {0}</translation>
    </message>
    <message>
        <source>frame {0} cannot be evaluated: {1}</source>
        <translation>no se puede evaluar el fotograma {0}: {1}</translation>
    </message>
</context>
<context>
    <name>CalibratingController</name>
    <message>
        <source>the board could not be saved: {0}</source>
        <translation>no se pudo guardar el tablero: {0}</translation>
    </message>
    <message>
        <source>Saved as {0}: print it on {1} at 100 %</source>
        <translation>Guardado como {0}: imprímalo en {1} al 100 %</translation>
    </message>
    <message>
        <source>Save the board</source>
        <translation>Guardar el tablero</translation>
    </message>
    <message>
        <source>Save the calibration</source>
        <translation>Guardar la calibración</translation>
    </message>
    <message>
        <source>Saved as {0}. Publish it with `grabbergui serve … --ros2 NAME --calibration {0}`</source>
        <translation>Guardada como {0}. Publíquela con `grabbergui serve … --ros2 NAME --calibration {0}`</translation>
    </message>
</context>
<context>
    <name>CalibrationChoiceDialog</name>
    <message>
        <source>The camera is not calibrated</source>
        <translation>La cámara no está calibrada</translation>
    </message>
    <message>
        <source>Positions are computed from the calibration of the lens. Without one nothing moves.</source>
        <translation>Las posiciones se calculan a partir de la calibración del objetivo. Sin ella nada se mueve.</translation>
    </message>
    <message>
        <source>&amp;Calibrate it now</source>
        <translation>&amp;Calibrarla ahora</translation>
    </message>
    <message>
        <source>With a printed board; takes about two minutes.</source>
        <translation>Con un tablero impreso; lleva unos dos minutos.</translation>
    </message>
    <message>
        <source>&amp;Open a calibration…</source>
        <translation>&amp;Abrir una calibración…</translation>
    </message>
    <message>
        <source>A camera_info file, of this camera with this lens and focus.</source>
        <translation>Un archivo camera_info de esta cámara, con este objetivo y este enfoque.</translation>
    </message>
    <message>
        <source>&amp;Assume a field of view</source>
        <translation>&amp;Suponer un campo de visión</translation>
    </message>
    <message>
        <source>Directions are about right, distances rough.</source>
        <translation>Las direcciones son casi exactas; las distancias, aproximadas.</translation>
    </message>
    <message>
        <source>Field of view</source>
        <translation>Campo de visión</translation>
    </message>
    <message>
        <source>Horizontal angle that the image covers</source>
        <translation>Ángulo horizontal que abarca la imagen</translation>
    </message>
    <message>
        <source>°</source>
        <translation>°</translation>
    </message>
    <message>
        <source>Cancel</source>
        <translation>Cancelar</translation>
    </message>
    <message>
        <source>{0} is not calibrated</source>
        <translation>{0} no está calibrada</translation>
    </message>
</context>
<context>
    <name>CalibrationChooser</name>
    <message>
        <source>Open a calibration</source>
        <translation>Abrir una calibración</translation>
    </message>
</context>
<context>
    <name>CalibrationDialog</name>
    <message>
        <source>Calibrate the camera</source>
        <translation>Calibrar la cámara</translation>
    </message>
    <message>
        <source>● waiting for an image</source>
        <translation>● esperando una imagen</translation>
    </message>
    <message>
        <source>Which board do you use? A ChArUco board may extend beyond the image and so covers its corners; a chessboard must be seen whole.</source>
        <translation>¿Qué tablero se muestra? Un tablero ChArUco puede salirse de la imagen y así llega a las esquinas; un tablero de ajedrez debe verse entero.</translation>
    </message>
    <message>
        <source>&amp;Board</source>
        <translation>&amp;Tablero</translation>
    </message>
    <message>
        <source>ChArUco</source>
        <translation>ChArUco</translation>
    </message>
    <message>
        <source>Chessboard</source>
        <translation>Tablero de ajedrez</translation>
    </message>
    <message>
        <source>Squares a&amp;cross</source>
        <translation>Casillas a lo a&amp;ncho</translation>
    </message>
    <message>
        <source>Squares &amp;down</source>
        <translation>Casillas a lo a&amp;lto</translation>
    </message>
    <message>
        <source>Edge of a &amp;field</source>
        <translation>Lado de una &amp;casilla</translation>
    </message>
    <message>
        <source>As measured on the paper; it sets the scale of all distances</source>
        <translation>Medido sobre el papel: las distancias serán tan exactas como esta medida</translation>
    </message>
    <message>
        <source> mm</source>
        <translation> mm</translation>
    </message>
    <message>
        <source>Edge of a &amp;marker</source>
        <translation>Lado de un &amp;marcador</translation>
    </message>
    <message>
        <source>D&amp;ictionary</source>
        <translation>&amp;Diccionario</translation>
    </message>
    <message>
        <source>Save the board for &amp;printing…</source>
        <translation>Guardar el tablero para im&amp;primirlo…</translation>
    </message>
    <message>
        <source>PDF or PNG at true scale; print at 100 %, and measure the rule</source>
        <translation>PDF o PNG a escala real; imprímalo al 100 % y mida la regla</translation>
    </message>
    <message>
        <source>Print it at 100 %, check the rule, and glue it onto something flat and stiff: paper that bends spoils the result.</source>
        <translation>Imprímalo al 100 %, compruebe la regla y péguelo sobre algo plano y rígido: un papel que se dobla estropea el resultado.</translation>
    </message>
    <message>
        <source>Hold the board still for a moment, then elsewhere: near and far, in every corner of the image, tilted every way. Views are taken automatically.</source>
        <translation>Mantenga quieto el tablero un momento y muévalo a otro lugar: cerca y lejos, en cada esquina de la imagen, inclinado de todas las maneras. Las vistas se toman solas.</translation>
    </message>
    <message>
        <source>%v of %m views</source>
        <translation>%v de %m vistas</translation>
    </message>
    <message>
        <source>&amp;Begin again</source>
        <translation>&amp;Empezar de nuevo</translation>
    </message>
    <message>
        <source>Discard the views taken so far</source>
        <translation>Olvidar las vistas tomadas hasta ahora</translation>
    </message>
    <message>
        <source>Views</source>
        <translation>Vistas</translation>
    </message>
    <message>
        <source>Untick a view to leave it out; choose one to see it, its errors enlarged</source>
        <translation>Desmarque una vista para excluirla; elija una para verla con sus errores ampliados</translation>
    </message>
    <message>
        <source>View</source>
        <translation>Vista</translation>
    </message>
    <message>
        <source>Corners</source>
        <translation>Esquinas</translation>
    </message>
    <message>
        <source>Error</source>
        <translation>Error</translation>
    </message>
    <message>
        <source>Take &amp;more views</source>
        <translation>Tomar &amp;más vistas</translation>
    </message>
    <message>
        <source>Bac&amp;k</source>
        <translation>&amp;Atrás</translation>
    </message>
    <message>
        <source>Close</source>
        <translation>Cerrar</translation>
    </message>
    <message>
        <source>&amp;Next</source>
        <translation>&amp;Siguiente</translation>
    </message>
    <message>
        <source>no images arrive from the camera</source>
        <translation>la cámara no envía imágenes</translation>
    </message>
    <message>
        <source>the board is seen</source>
        <translation>se ve el tablero</translation>
    </message>
    <message>
        <source>Board</source>
        <translation>Tablero</translation>
    </message>
    <message>
        <source>Result</source>
        <translation>Resultado</translation>
    </message>
    <message>
        <source>Take &amp;views</source>
        <translation>Tomar &amp;vistas</translation>
    </message>
    <message>
        <source>&amp;Finish</source>
        <translation>&amp;Terminar</translation>
    </message>
    <message>
        <source>&amp;Save…</source>
        <translation>&amp;Guardar…</translation>
    </message>
    <message>
        <source>{0:.0%} of the image is covered</source>
        <translation>Está cubierto el {0:.0%} de la imagen</translation>
    </message>
    <message>
        <source>&lt;b&gt;{0:.3f} px&lt;/b&gt; over {1} views</source>
        <translation>&lt;b&gt;{0:.3f} px&lt;/b&gt; en {1} vistas</translation>
    </message>
    <message>
        <source>Focal lengths</source>
        <translation>Distancias focales</translation>
    </message>
    <message>
        <source>Centre</source>
        <translation>Centro</translation>
    </message>
    <message>
        <source>Distortion</source>
        <translation>Distorsión</translation>
    </message>
    <message>
        <source>{0}, left out</source>
        <translation>{0}, excluida</translation>
    </message>
    <message>
        <source>view {0}, errors enlarged {1} times</source>
        <translation>vista {0}, errores ampliados {1} veces</translation>
    </message>
    <message>
        <source>Live image</source>
        <translation>Imagen en directo</translation>
    </message>
    <message>
        <source>Tilts and distances that were seen</source>
        <translation>Inclinaciones y distancias vistas</translation>
    </message>
    <message>
        <source>Discard {0} views?</source>
        <translation>¿Descartar {0} vistas?</translation>
    </message>
    <message>
        <source>The calibration that is computed from them has not been saved.</source>
        <translation>La calibración calculada a partir de ellas no se ha guardado.</translation>
    </message>
    <message>
        <source>Discard them</source>
        <translation>Descartarlas</translation>
    </message>
    <message>
        <source>Keep them</source>
        <translation>Conservarlas</translation>
    </message>
    <message>
        <source>Discard the view?</source>
        <translation>¿Descartar la vista?</translation>
    </message>
</context>
<context>
    <name>CalibrationViewController</name>
    <message>
        <source>Load a calibration</source>
        <translation>Cargar una calibración</translation>
    </message>
    <message>
        <source>{0}: the image is shown undistorted, {1:.0f}° × {2:.0f}°</source>
        <translation>{0}: la imagen se muestra sin distorsión, {1:.0f}° × {2:.0f}°</translation>
    </message>
    <message>
        <source>{0} was made with another camera, {1} {2}; calibrate this one as well</source>
        <translation>{0} se hizo con otra cámara, {1} {2}; calibre también esta</translation>
    </message>
</context>
<context>
    <name>CameraEventsDialog</name>
    <message>
        <source>Events of the camera</source>
        <translation>Eventos de la cámara</translation>
    </message>
    <message>
        <source>Tick the events that the camera should report. They are marks on the curves of values, too.</source>
        <translation>Marque los eventos que la cámara debe comunicar. También son marcas en las curvas.</translation>
    </message>
    <message>
        <source>Events that the camera can report</source>
        <translation>Eventos que la cámara puede comunicar</translation>
    </message>
    <message>
        <source>Events that arrived, the newest first</source>
        <translation>Eventos recibidos, el más reciente primero</translation>
    </message>
    <message>
        <source>Time</source>
        <translation>Hora</translation>
    </message>
    <message>
        <source>Event</source>
        <translation>Evento</translation>
    </message>
    <message>
        <source>Values</source>
        <translation>Valores</translation>
    </message>
    <message>
        <source>C&amp;lear</source>
        <translation>&amp;Vaciar</translation>
    </message>
    <message>
        <source>&amp;Copy</source>
        <translation>&amp;Copiar</translation>
    </message>
    <message>
        <source>Close</source>
        <translation>Cerrar</translation>
    </message>
</context>
<context>
    <name>CameraFilesController</name>
    <message>
        <source>Listing the camera&apos;s files</source>
        <translation>Listando los archivos de la cámara</translation>
    </message>
    <message>
        <source>Save {0}</source>
        <translation>Guardar {0}</translation>
    </message>
    <message>
        <source>All files (*)</source>
        <translation>Todos los archivos (*)</translation>
    </message>
    <message>
        <source>{0} ({1} B) saved as {2}</source>
        <translation>{0} ({1} B) guardado como {2}</translation>
    </message>
    <message>
        <source>Downloading {0}</source>
        <translation>Descargando {0}</translation>
    </message>
    <message>
        <source>File for {0}</source>
        <translation>Archivo para {0}</translation>
    </message>
    <message>
        <source>{0} ({1} B) written and read back</source>
        <translation>{0} ({1} B) escrito y comprobado leyéndolo</translation>
    </message>
    <message>
        <source>{0} ({1} B) written; the camera does not let it be read back</source>
        <translation>{0} ({1} B) escrito; la cámara no permite volver a leerlo</translation>
    </message>
    <message>
        <source>Uploading {0}</source>
        <translation>Subiendo {0}</translation>
    </message>
    <message>
        <source>{0} is deleted</source>
        <translation>{0} se ha eliminado</translation>
    </message>
    <message>
        <source>Deleting {0}</source>
        <translation>Eliminando {0}</translation>
    </message>
</context>
<context>
    <name>CameraFilesDialog</name>
    <message>
        <source>Files in the camera</source>
        <translation>Archivos de la cámara</translation>
    </message>
    <message>
        <source>Look-up tables, shading data, logs, firmware: the camera&apos;s manual describes their content. An upload is read back and compared.</source>
        <translation>Tablas de consulta, datos de sombreado, registros, firmware: el manual de la cámara describe su contenido. Lo que se sube se vuelve a leer y se compara.</translation>
    </message>
    <message>
        <source>Name</source>
        <translation>Nombre</translation>
    </message>
    <message>
        <source>Size</source>
        <translation>Tamaño</translation>
    </message>
    <message>
        <source>Details</source>
        <translation>Detalles</translation>
    </message>
    <message>
        <source>Progress of the transfer</source>
        <translation>Progreso de la transferencia</translation>
    </message>
    <message>
        <source>End the transfer; an upload that ends early has to be repeated as a whole</source>
        <translation>Terminar la transferencia; una subida que termina antes debe repetirse entera</translation>
    </message>
    <message>
        <source>Ca&amp;ncel</source>
        <translation>Ca&amp;ncelar</translation>
    </message>
    <message>
        <source>Save this file on the computer</source>
        <translation>Guardar este archivo en el ordenador</translation>
    </message>
    <message>
        <source>&amp;Download…</source>
        <translation>&amp;Descargar…</translation>
    </message>
    <message>
        <source>Replace this file in the camera by one of the computer</source>
        <translation>Sustituir este archivo de la cámara por uno del ordenador</translation>
    </message>
    <message>
        <source>&amp;Upload…</source>
        <translation>&amp;Subir…</translation>
    </message>
    <message>
        <source>Delete this file in the camera</source>
        <translation>Eliminar este archivo de la cámara</translation>
    </message>
    <message>
        <source>D&amp;elete…</source>
        <translation>&amp;Eliminar…</translation>
    </message>
    <message>
        <source>Close</source>
        <translation>Cerrar</translation>
    </message>
    <message>
        <source>Replace {0} in the camera by {1}?</source>
        <translation>¿Sustituir {0} en la cámara por {1}?</translation>
    </message>
    <message>
        <source>This is firmware: a wrong file, or a power cut meanwhile, may leave the camera useless.</source>
        <translation>Es firmware: un archivo equivocado, o un corte de corriente mientras tanto, puede dejar la cámara inservible.</translation>
    </message>
    <message>
        <source>Replace the firmware</source>
        <translation>Sustituir el firmware</translation>
    </message>
    <message>
        <source>The camera keeps no copy of its present content.</source>
        <translation>La cámara no guarda copia de su contenido actual.</translation>
    </message>
    <message>
        <source>Replace</source>
        <translation>Sustituir</translation>
    </message>
    <message>
        <source>Delete {0} in the camera?</source>
        <translation>¿Eliminar {0} de la cámara?</translation>
    </message>
    <message>
        <source>This cannot be undone.</source>
        <translation>No se puede deshacer.</translation>
    </message>
    <message>
        <source>Delete</source>
        <translation>Eliminar</translation>
    </message>
    <message>
        <source>{0} B</source>
        <translation>{0} B</translation>
    </message>
</context>
<context>
    <name>CameraTile</name>
    <message>
        <source>Close</source>
        <translation>Cerrar</translation>
    </message>
    <message>
        <source>Close this source</source>
        <translation>Cerrar esta fuente</translation>
    </message>
    <message>
        <source>Close {0}</source>
        <translation>Cerrar {0}</translation>
    </message>
    <message>
        <source>This is the current source</source>
        <translation>Esta es la fuente activa</translation>
    </message>
    <message>
        <source>Make this the current source</source>
        <translation>Hacer activa esta fuente</translation>
    </message>
    <message>
        <source>This source is being recorded</source>
        <translation>Esta fuente se está grabando</translation>
    </message>
</context>
<context>
    <name>CameraWork</name>
    <message>
        <source>there is no camera; connect to one first</source>
        <translation>no hay ninguna cámara; conéctese antes a una</translation>
    </message>
</context>
<context>
    <name>ChangeTable</name>
    <message>
        <source>Time</source>
        <translation>Hora</translation>
    </message>
    <message>
        <source>Feature</source>
        <translation>Parámetro</translation>
    </message>
    <message>
        <source>Before</source>
        <translation>Antes</translation>
    </message>
    <message>
        <source>After</source>
        <translation>Después</translation>
    </message>
    <message>
        <source>By</source>
        <translation>Por</translation>
    </message>
    <message>
        <source>Part of</source>
        <translation>Parte de</translation>
    </message>
    <message>
        <source>operator</source>
        <translation>operador</translation>
    </message>
    <message>
        <source>camera</source>
        <translation>cámara</translation>
    </message>
    <message>
        <source>network</source>
        <translation>red</translation>
    </message>
    <message>
        <source>run</source>
        <translation>ejecutado</translation>
    </message>
</context>
<context>
    <name>Changes</name>
    <message>
        <source>Undo</source>
        <translation>Deshacer</translation>
    </message>
    <message>
        <source>Redo</source>
        <translation>Rehacer</translation>
    </message>
    <message>
        <source>{0} of {1}: {2}</source>
        <translation>{0} {1}: {2}</translation>
    </message>
</context>
<context>
    <name>ChangesController</name>
    <message>
        <source>&amp;Undo</source>
        <translation>&amp;Deshacer</translation>
    </message>
    <message>
        <source>&amp;Redo</source>
        <translation>&amp;Rehacer</translation>
    </message>
    <message>
        <source>Save changes</source>
        <translation>Guardar los cambios</translation>
    </message>
    <message>
        <source>Python program (*.py);;Shell script (*.sh);;Table (*.tsv)</source>
        <translation>Programa de Python (*.py);;Script de shell (*.sh);;Tabla (*.tsv)</translation>
    </message>
    <message>
        <source>Saved the changes to {0}</source>
        <translation>Cambios guardados en {0}</translation>
    </message>
</context>
<context>
    <name>ChangesPanel</name>
    <message>
        <source>Show the changes of</source>
        <translation>De quién son los cambios que se muestran</translation>
    </message>
    <message>
        <source>Whose changes</source>
        <translation>Cambios de quién</translation>
    </message>
    <message>
        <source>Everybody’s changes</source>
        <translation>Cambios de todos</translation>
    </message>
    <message>
        <source>The operator’s changes</source>
        <translation>Cambios del operador</translation>
    </message>
    <message>
        <source>Copy the selected changes, or else all shown, in a form that repeats them</source>
        <translation>Copiar lo seleccionado, o si no todo lo mostrado, como algo que repite los cambios</translation>
    </message>
    <message>
        <source>Copy as</source>
        <translation>Copiar</translation>
    </message>
    <message>
        <source>Save the selected changes, or else all shown: a Python program, a shell script or a table</source>
        <translation>Guardar lo seleccionado, o si no todo lo mostrado: programa de Python, script de shell o tabla</translation>
    </message>
    <message>
        <source>Save…</source>
        <translation>Guardar…</translation>
    </message>
    <message>
        <source>Clear the list; steps can still be undone</source>
        <translation>Olvidar la lista; lo que se puede deshacer se conserva</translation>
    </message>
    <message>
        <source>Clear</source>
        <translation>Vaciar</translation>
    </message>
    <message>
        <source>Changes</source>
        <translation>Cambios</translation>
    </message>
    <message>
        <source>&amp;Command line</source>
        <translation>&amp;Línea de órdenes</translation>
    </message>
    <message>
        <source>&amp;Python program</source>
        <translation>Programa de &amp;Python</translation>
    </message>
    <message>
        <source>&amp;Table</source>
        <translation>&amp;Tabla</translation>
    </message>
    <message>
        <source>Without the camera’s own</source>
        <translation>Sin los de la propia cámara</translation>
    </message>
</context>
<context>
    <name>CodedNumberEditor</name>
    <message>
        <source>“{0}” is not an IPv4 address</source>
        <translation>«{0}» no es una dirección IPv4</translation>
    </message>
    <message>
        <source>“{0}” is not a MAC address</source>
        <translation>«{0}» no es una dirección MAC</translation>
    </message>
    <message>
        <source>“{0}” is not a number</source>
        <translation>«{0}» no es un número</translation>
    </message>
</context>
<context>
    <name>CommandEditor</name>
    <message>
        <source>Run</source>
        <translation>Ejecutar</translation>
    </message>
</context>
<context>
    <name>Components</name>
    <message>
        <source>Intensity</source>
        <translation>Intensidad</translation>
    </message>
    <message>
        <source>Infrared</source>
        <translation>Infrarrojo</translation>
    </message>
    <message>
        <source>Ultraviolet</source>
        <translation>Ultravioleta</translation>
    </message>
    <message>
        <source>Range</source>
        <translation>Distancia</translation>
    </message>
    <message>
        <source>Reflectance</source>
        <translation>Reflectancia</translation>
    </message>
    <message>
        <source>Confidence</source>
        <translation>Confianza</translation>
    </message>
    <message>
        <source>Scatter</source>
        <translation>Dispersión</translation>
    </message>
    <message>
        <source>Disparity</source>
        <translation>Disparidad</translation>
    </message>
    <message>
        <source>Multispectral</source>
        <translation>Multiespectral</translation>
    </message>
    <message>
        <source>Component</source>
        <translation>Componente</translation>
    </message>
    <message>
        <source>{0}, source {1}</source>
        <translation>{0}, fuente {1}</translation>
    </message>
</context>
<context>
    <name>Connection</name>
    <message>
        <source>{0} is open already</source>
        <translation>{0} ya está abierta</translation>
    </message>
    <message>
        <source>stopping failed: {0}</source>
        <translation>no se pudo parar: {0}</translation>
    </message>
    <message>
        <source>{0} does not start: {1}</source>
        <translation>{0} no arranca: {1}</translation>
    </message>
    <message>
        <source>reconnecting since {0}: {1}</source>
        <translation>reconectando desde las {0}: {1}</translation>
    </message>
    <message>
        <source>back after {0} s</source>
        <translation>de vuelta tras {0} s</translation>
    </message>
    <message>
        <source>read only: {0}; values follow here but cannot be changed</source>
        <translation>solo lectura: {0}; los valores se siguen aquí, pero no se pueden cambiar</translation>
    </message>
    <message>
        <source>Take control</source>
        <translation>Tomar el control</translation>
    </message>
    <message>
        <source>this window has control now: values can be changed</source>
        <translation>esta ventana tiene ahora el control: los valores se pueden cambiar</translation>
    </message>
    <message>
        <source>control was not given: {0}; still read only</source>
        <translation>no se cedió el control: {0}; sigue solo de lectura</translation>
    </message>
</context>
<context>
    <name>CoverageView</name>
    <message>
        <source>Tilts</source>
        <translation>Inclinaciones</translation>
    </message>
    <message>
        <source>Distances</source>
        <translation>Distancias</translation>
    </message>
    <message>
        <source>far</source>
        <translation>lejos</translation>
    </message>
    <message>
        <source>between</source>
        <translation>en medio</translation>
    </message>
    <message>
        <source>near</source>
        <translation>cerca</translation>
    </message>
</context>
<context>
    <name>CurveRow</name>
    <message>
        <source>Remove this curve</source>
        <translation>Quitar esta curva</translation>
    </message>
    <message>
        <source>{0} over time</source>
        <translation>{0} en el tiempo</translation>
    </message>
</context>
<context>
    <name>Diagnosis</name>
    <message>
        <source>Frames arrive but cannot be shown: {0}</source>
        <translation>Llegan imágenes pero no se pueden mostrar: {0}</translation>
    </message>
    <message>
        <source>Choose another PixelFormat; a snapshot still saves the raw bytes.</source>
        <translation>Elija otro PixelFormat; una captura guarda de todos modos los bytes en bruto.</translation>
    </message>
    <message>
        <source>Frames arrive but the window does not paint them.</source>
        <translation>Llegan imágenes pero la ventana no las dibuja.</translation>
    </message>
    <message>
        <source>See the log.</source>
        <translation>Vea el registro.</translation>
    </message>
    <message>
        <source>Check the cable and the camera&apos;s power; then stop and start again.</source>
        <translation>Compruebe el cable y la alimentación de la cámara; luego pare e inicie de nuevo.</translation>
    </message>
    <message>
        <source> (GevSCPSPacketSize, now {0} bytes)</source>
        <translation> (GevSCPSPacketSize, ahora {0} bytes)</translation>
    </message>
    <message>
        <source>Packets arrive, but no frame is complete: {0} packets are missing.</source>
        <translation>Llegan paquetes, pero ninguna imagen está completa: faltan {0} paquetes.</translation>
    </message>
    <message>
        <source>{0} packets arrived, but no frame was finished.</source>
        <translation>Llegaron {0} paquetes, pero no se completó ninguna imagen.</translation>
    </message>
    <message>
        <source>{0} is under control but sends nothing that arrives here.</source>
        <translation>{0} está bajo control pero no envía nada que llegue aquí.</translation>
    </message>
    <message>
        <source>Stop and start again; check the camera&apos;s cable and power.</source>
        <translation>Pare e inicie de nuevo; compruebe el cable y la alimentación de la cámara.</translation>
    </message>
    <message>
        <source>UDP port {0}</source>
        <translation>el puerto UDP {0}</translation>
    </message>
    <message>
        <source>from the camera</source>
        <translation>desde la cámara</translation>
    </message>
    <message>
        <source>from {0}</source>
        <translation>desde {0}</translation>
    </message>
    <message>
        <source> Packets of {0} bytes need an MTU as large on every device between.</source>
        <translation> Los paquetes de {0} bytes necesitan una MTU igual de grande en cada dispositivo intermedio.</translation>
    </message>
    <message>
        <source>A firewall may drop it: let {0} {1} pass{2}.{3}</source>
        <translation>Un cortafuegos puede descartarlo: deje pasar {0} {1}{2}.{3}</translation>
    </message>
    <message>
        <source>Packets arrive, but no frame is complete: 1 packet is missing.</source>
        <translation>Llegan paquetes, pero ninguna imagen está completa: falta 1 paquete.</translation>
    </message>
    <message>
        <source>1 packet arrived, but no frame was finished.</source>
        <translation>Llegó 1 paquete, pero no se completó ninguna imagen.</translation>
    </message>
    <message>
        <source>No frame for {1:.0f} s, after 1 frame.</source>
        <translation>Ninguna imagen desde hace {1:.0f} s, tras una que llegó.</translation>
    </message>
    <message>
        <source>No frame for {1:.0f} s, after {0} frames.</source>
        <translation>Ninguna imagen desde hace {1:.0f} s, tras {0} que llegaron.</translation>
    </message>
    <message>
        <source>Choose smaller packets{0} or a longer packet delay (GevSCPD); raise net.core.rmem_max.</source>
        <translation>Elija paquetes más pequeños{0} o un retardo mayor entre paquetes (GevSCPD); aumente net.core.rmem_max.</translation>
    </message>
    <message>
        <source>The frame rate may be very low, or packets larger than the network&apos;s MTU are dropped.</source>
        <translation>La frecuencia puede ser muy baja, o se descartan los paquetes mayores que la MTU de la red.</translation>
    </message>
    <message>
        <source>an input</source>
        <translation>una entrada</translation>
    </message>
    <message>
        <source>The recorded image is black.</source>
        <translation>La imagen grabada es negra.</translation>
    </message>
    <message>
        <source>The image is black.</source>
        <translation>La imagen es negra.</translation>
    </message>
    <message>
        <source>The image is black: the exposure ({0}) may be too short.</source>
        <translation>La imagen es negra: la exposición ({0}) puede ser demasiado corta.</translation>
    </message>
    <message>
        <source>Open the iris, or take the lens cap off.</source>
        <translation>Abra el iris o quite la tapa del objetivo.</translation>
    </message>
    <message>
        <source>Raise exposure or gain, or press E.</source>
        <translation>Aumente la exposición o la ganancia, o pulse E.</translation>
    </message>
    <message>
        <source>Raise the exposure, or press E.</source>
        <translation>Aumente la exposición o pulse E.</translation>
    </message>
    <message>
        <source>Raise the gain, or press E.</source>
        <translation>Aumente la ganancia o pulse E.</translation>
    </message>
    <message>
        <source>See whether its program sends images, and whether a camera there waits for a trigger.</source>
        <translation>Compruebe si su programa envía imágenes y si una cámara de allí espera un disparo.</translation>
    </message>
    <message>
        <source>Packets arrive, but no frame can be made of them.</source>
        <translation>Llegan paquetes, pero no se puede formar ningún fotograma con ellos.</translation>
    </message>
</context>
<context>
    <name>DoctorDialog</name>
    <message>
        <source>Doctor</source>
        <translation>Diagnóstico</translation>
    </message>
    <message>
        <source>Findings</source>
        <translation>Resultados</translation>
    </message>
    <message>
        <source>Checking this computer…</source>
        <translation>Revisando este equipo…</translation>
    </message>
    <message>
        <source>Nothing is wrong</source>
        <translation>No hay ningún problema</translation>
    </message>
    <message>
        <source>Check &amp;again</source>
        <translation>Comprobar de &amp;nuevo</translation>
    </message>
    <message>
        <source>Copy all findings and remedies as text</source>
        <translation>Copiar todos los resultados y remedios como texto</translation>
    </message>
    <message>
        <source>&amp;Copy</source>
        <translation>&amp;Copiar</translation>
    </message>
    <message>
        <source>Close</source>
        <translation>Cerrar</translation>
    </message>
    <message>
        <source>OK</source>
        <translation>Bien</translation>
    </message>
    <message>
        <source>Warning</source>
        <translation>Aviso</translation>
    </message>
    <message>
        <source>Fault</source>
        <translation>Fallo</translation>
    </message>
    <message>
        <source>Applying the remedy: {0}</source>
        <translation>Aplicando el remedio: {0}</translation>
    </message>
    <message>
        <source>1 fault</source>
        <translation>1 fallo</translation>
    </message>
    <message>
        <source>{0} faults</source>
        <translation>{0} fallos</translation>
    </message>
    <message>
        <source>1 warning</source>
        <translation>1 aviso</translation>
    </message>
    <message>
        <source>{0} warnings</source>
        <translation>{0} avisos</translation>
    </message>
</context>
<context>
    <name>DoctorRow</name>
    <message>
        <source>Do it</source>
        <translation>Hacerlo</translation>
    </message>
</context>
<context>
    <name>Drivers</name>
    <message>
        <source>the camera is lost: {0}</source>
        <translation>se perdió la cámara: {0}</translation>
    </message>
    <message>
        <source>another application, at {0}, took control of the camera</source>
        <translation>otra aplicación, en {0}, tomó el control de la cámara</translation>
    </message>
    <message>
        <source>the camera took our control back; its heartbeat may have expired, or it has restarted</source>
        <translation>la cámara retiró el control; puede que expirase su heartbeat o que se haya reiniciado</translation>
    </message>
    <message>
        <source>{0} was lost while it was opened</source>
        <translation>{0} se perdió mientras se abría</translation>
    </message>
    <message>
        <source>{0} is not open</source>
        <translation>{0} no está abierta</translation>
    </message>
    <message>
        <source>{0} was unplugged</source>
        <translation>{0} se desconectó</translation>
    </message>
    <message>
        <source>{0} was not acknowledged within {1} s ({2} tries)</source>
        <translation>{0} no se confirmó en {1} s (intentos: {2})</translation>
    </message>
    <message>
        <source>{0} was not acknowledged within {1} s; the camera had asked for more time</source>
        <translation>{0} no se confirmó en {1} s; la cámara había pedido más tiempo</translation>
    </message>
    <message>
        <source>{0} did not answer in time</source>
        <translation>{0} no respondió a tiempo</translation>
    </message>
    <message>
        <source>{0} did not answer within {1} s</source>
        <translation>{0} no respondió en {1} s</translation>
    </message>
    <message>
        <source>the device takes no commands; unplug it and plug it in again</source>
        <translation>el dispositivo no acepta órdenes; desconéctelo y vuelva a conectarlo</translation>
    </message>
    <message>
        <source>another application at {0} controls {1}; close it there</source>
        <translation>otra aplicación en {0} controla {1}; ciérrela allí</translation>
    </message>
    <message>
        <source>another application controls {0}; close it there</source>
        <translation>otra aplicación controla {0}; ciérrela allí</translation>
    </message>
    <message>
        <source>{0} is in use by another application; close it there</source>
        <translation>otra aplicación usa {0}; ciérrela allí</translation>
    </message>
    <message>
        <source>the camera is open for reading only; another application may control it</source>
        <translation>la cámara está abierta solo para lectura; puede que otra aplicación la controle</translation>
    </message>
    <message>
        <source>the camera answers reads but not this write; another application may control it</source>
        <translation>la cámara responde a las lecturas pero no a esta escritura; puede que otra aplicación la controle</translation>
    </message>
    <message>
        <source>the camera is served read-only</source>
        <translation>la cámara se sirve solo para lectura</translation>
    </message>
    <message>
        <source>{0} is not there any more</source>
        <translation>{0} ya no existe</translation>
    </message>
    <message>
        <source>{0} is {1} instead of {2}</source>
        <translation>{0} es {1} en lugar de {2}</translation>
    </message>
    <message>
        <source>the camera did not answer for {0} s</source>
        <translation>la cámara no respondió durante {0} s</translation>
    </message>
    <message>
        <source>the target is not seen: bring it into the middle of the image first</source>
        <translation>no se ve el objetivo: llévelo primero al centro de la imagen</translation>
    </message>
    <message>
        <source>only {0} of {1} views were possible: give the arm more room, or move the target</source>
        <translation>solo fueron posibles {0} de {1} vistas: dé más espacio al brazo o mueva el objetivo</translation>
    </message>
    <message>
        <source>only {0} of {1} poses show the target, {2} are wanted: move it, or take a smaller one</source>
        <translation>solo {0} de {1} posturas muestran el objetivo y se quieren {2}: muévalo o use uno más pequeño</translation>
    </message>
    <message>
        <source>hand–eye calibration needs {0} views or more, not {1}</source>
        <translation>la calibración mano-ojo necesita {0} vistas o más, no {1}</translation>
    </message>
    <message>
        <source>the views differ too little: turn camera or target about two axes between them</source>
        <translation>las vistas se diferencian muy poco: gire la cámara o el objetivo sobre dos ejes entre ellas</translation>
    </message>
    <message>
        <source>the views contradict one another: check the target&apos;s size and the calibration</source>
        <translation>las vistas se contradicen: compruebe el tamaño del objetivo y la calibración</translation>
    </message>
    <message>
        <source>no image arrived within {0} s: check camera and cable</source>
        <translation>no llegó ninguna imagen en {0} s: compruebe la cámara y el cable</translation>
    </message>
    <message>
        <source>there is no camera to look with</source>
        <translation>no hay cámara con la que mirar</translation>
    </message>
    <message>
        <source>the robot is stopped: {0}</source>
        <translation>el robot está parado: {0}</translation>
    </message>
    <message>
        <source>{0} does not report its joints</source>
        <translation>{0} no comunica sus articulaciones</translation>
    </message>
    <message>
        <source>{0} does not report the angles of its arm</source>
        <translation>{0} no comunica los ángulos de su brazo</translation>
    </message>
    <message>
        <source>{0} no longer reports the angles of its arm</source>
        <translation>{0} ya no comunica los ángulos de su brazo</translation>
    </message>
    <message>
        <source>the head of {0} is not driven</source>
        <translation>la cabeza de {0} no está accionada</translation>
    </message>
    <message>
        <source>the arm of {0} is not driven</source>
        <translation>el brazo de {0} no está accionado</translation>
    </message>
    <message>
        <source>this is a dry run, in which the robot does not move: start without --dry-run</source>
        <translation>esto es una prueba en la que el robot no se mueve: arranque sin --dry-run</translation>
    </message>
    <message>
        <source>it would leave the workspace ({0} = {1} m)</source>
        <translation>saldría del espacio de trabajo ({0} = {1} m)</translation>
    </message>
    <message>
        <source>it would leave the workspace ({0})</source>
        <translation>saldría del espacio de trabajo ({0})</translation>
    </message>
    <message>
        <source>{0} would come within {1} mm of {2}</source>
        <translation>{0} se acercaría a {1} mm de {2}</translation>
    </message>
    <message>
        <source>a pitch of {0} m must be more than the markers&apos; size, {1} m, or they would overlap</source>
        <translation>un paso de {0} m debe ser mayor que el tamaño de los marcadores, {1} m, o se solaparían</translation>
    </message>
    <message>
        <source>two poses explain it</source>
        <translation>dos posturas lo explican</translation>
    </message>
    <message>
        <source>it is seen edge-on</source>
        <translation>se ve de canto</translation>
    </message>
    <message>
        <source>its corners are no square&apos;s</source>
        <translation>sus esquinas no son las de un cuadrado</translation>
    </message>
    <message>
        <source>this program controls {0} already; close it first</source>
        <translation>este programa ya controla {0}; ciérrela primero</translation>
    </message>
    <message>
        <source>another application took exclusive control of the camera</source>
        <translation>otra aplicación tomó el control exclusivo de la cámara</translation>
    </message>
    <message>
        <source>another application has exclusive control of the camera at {0}; close it there</source>
        <translation>otra aplicación tiene el control exclusivo de la cámara en {0}; ciérrela allí</translation>
    </message>
    <message>
        <source>{0}: its USB bus has too little bandwidth left; choose a smaller size, MJPG or a lower rate, or plug it in elsewhere</source>
        <translation>{0}: a su bus USB le queda poco ancho de banda; elija un tamaño menor, MJPG o una frecuencia más baja, o conéctela en otro puerto</translation>
    </message>
    <message>
        <source>{0} is set to {1}, which cannot be shown; choose another PixelFormat</source>
        <translation>{0} está en {1}, que no se puede mostrar; elija otro PixelFormat</translation>
    </message>
    <message>
        <source>{0} is there already; a recording overwrites nothing, choose another name</source>
        <translation>{0} ya existe; una grabación no sobrescribe nada, elija otro nombre</translation>
    </message>
    <message>
        <source>{0} could not be created: {1}; choose another folder or name</source>
        <translation>no se pudo crear {0}: {1}; elija otra carpeta u otro nombre</translation>
    </message>
    <message>
        <source>the snapshot could not be written to {0}: {1}; choose another folder</source>
        <translation>no se pudo guardar la captura en {0}: {1}; elija otra carpeta</translation>
    </message>
    <message>
        <source>{0} could not be written: {1}</source>
        <translation>no se pudo escribir {0}: {1}</translation>
    </message>
    <message>
        <source>{0} could not be read: {1}</source>
        <translation>no se pudo leer {0}: {1}</translation>
    </message>
    <message>
        <source>&apos;{0}&apos; is no source; did you mean {1}?</source>
        <translation>«{0}» no es una fuente; ¿quería decir {1}?</translation>
    </message>
    <message>
        <source>&apos;{0}&apos; is no source; write its kind first, as in sim: or gige:192.168.0.10</source>
        <translation>«{0}» no es una fuente; escriba antes su tipo, como en sim: o gige:192.168.0.10</translation>
    </message>
    <message>
        <source>&apos;{0}&apos; is of no known kind; there are {1}</source>
        <translation>«{0}» es de un tipo desconocido; existen {1}</translation>
    </message>
    <message>
        <source>{0} is not connected to this program at the moment</source>
        <translation>{0} no está conectado a este programa en este momento</translation>
    </message>
    <message>
        <source>{0} sends messages that are no images ({1})</source>
        <translation>{0} envía mensajes que no son imágenes ({1})</translation>
    </message>
    <message>
        <source>{0} is connected over {1} and sends nothing</source>
        <translation>{0} está conectado por {1} y no envía nada</translation>
    </message>
    <message>
        <source>{0} is subscribed to, and {1} sends nothing that arrives here</source>
        <translation>{0} está suscrito y {1} no envía nada que llegue aquí</translation>
    </message>
    <message>
        <source>nobody publishes {0}</source>
        <translation>nadie publica {0}</translation>
    </message>
    <message>
        <source>the camera sees this computer at {0}, not at {1}: a router between them translates addresses (NAT), so frames do not get through; give this computer an address in the camera&apos;s network</source>
        <translation>la cámara ve este ordenador en {0}, no en {1}: un router intermedio traduce direcciones (NAT), así que los fotogramas no llegan; dé a este ordenador una dirección en la red de la cámara</translation>
    </message>
    <message>
        <source>no packet arrives; {0} and {1} are in one subnet, {2}; the system may use the wrong one for a camera: give {3} and its cameras addresses of another subnet</source>
        <translation>no llega ningún paquete; {0} y {1} están en la misma subred, {2}; el sistema puede usar la equivocada para una cámara: dé a {3} y a sus cámaras direcciones de otra subred</translation>
    </message>
    <message>
        <source>no packet arrives; a firewall may drop them: {0}</source>
        <translation>no llega ningún paquete; un cortafuegos puede descartarlos: {0}</translation>
    </message>
    <message>
        <source>there is no edge on {0}, it is always low: check the cable, LineMode and the sender</source>
        <translation>no hay ningún flanco en {0}, siempre está en bajo: compruebe el cable, LineMode y el emisor</translation>
    </message>
    <message>
        <source>there is no edge on {0}, it is always high: check the cable, LineMode and the sender</source>
        <translation>no hay ningún flanco en {0}, siempre está en alto: compruebe el cable, LineMode y el emisor</translation>
    </message>
    <message>
        <source>there is no edge on {0}: check the cable, LineMode and the sender</source>
        <translation>no hay ningún flanco en {0}: compruebe el cable, LineMode y el emisor</translation>
    </message>
    <message>
        <source>no trigger arrives on {0}; it is low</source>
        <translation>no llega ningún disparo a {0}; está en bajo</translation>
    </message>
    <message>
        <source>no trigger arrives on {0}; it is high</source>
        <translation>no llega ningún disparo a {0}; está en alto</translation>
    </message>
    <message>
        <source>no trigger arrives on {0}</source>
        <translation>no llega ningún disparo a {0}</translation>
    </message>
    <message>
        <source>{0} has only edges of the other kind; set TriggerActivation to {1}, or switch LineInverter</source>
        <translation>{0} solo tiene flancos del otro tipo; ponga TriggerActivation en {1} o cambie LineInverter</translation>
    </message>
    <message>
        <source>the camera triggers at the end of each pulse, {0} µs late; set TriggerActivation to {1}, or switch LineInverter</source>
        <translation>la cámara dispara al final de cada pulso, {0} µs tarde; ponga TriggerActivation en {1} o cambie LineInverter</translation>
    </message>
    <message>
        <source>pulses missing between the others: {0}; the sender or the cable drops some</source>
        <translation>pulsos que faltan entre los demás: {0}; el emisor o el cable pierde algunos</translation>
    </message>
    <message>
        <source>triggers come at {0} Hz, but exposure and readout allow {1} Hz; {2} were missed (without overlap of exposure and readout; with it {3} Hz)</source>
        <translation>los disparos llegan a {0} Hz, pero exposición y lectura permiten {1} Hz; se perdieron {2} (sin solapar exposición y lectura; con solape, {3} Hz)</translation>
    </message>
    <message>
        <source>triggers come at {0} Hz, but exposure and readout allow {1} Hz; {2} were missed</source>
        <translation>los disparos llegan a {0} Hz, pero exposición y lectura permiten {1} Hz; se perdieron {2}</translation>
    </message>
    <message>
        <source>a trigger makes {0} frames instead of {1}; each frame waits for a trigger of its own: set TriggerMode[TriggerSelector=FrameStart] to Off</source>
        <translation>un disparo produce {0} imágenes en vez de {1}; cada una espera su propio disparo: ponga TriggerMode[TriggerSelector=FrameStart] en Off</translation>
    </message>
    <message>
        <source>a trigger makes {0} frames instead of {1}; the acquisition ends before: check AcquisitionMode and AcquisitionFrameCount</source>
        <translation>un disparo produce {0} imágenes en vez de {1}; la adquisición termina antes: compruebe AcquisitionMode y AcquisitionFrameCount</translation>
    </message>
    <message>
        <source>the camera ignores the actions: {0}</source>
        <translation>la cámara ignora las acciones: {0}</translation>
    </message>
    <message>
        <source>edges within {0} µs of another: {1}; a contact bounces: use a debouncer (LineDebouncerTime) or a clean signal</source>
        <translation>flancos a menos de {0} µs de otro: {1}; un contacto rebota: use LineDebouncerTime o una señal limpia</translation>
    </message>
    <message>
        <source>double pulses, {0} ms apart: {1}; are there two senders on the line?</source>
        <translation>pulsos dobles, separados {0} ms: {1}; ¿hay dos emisores en la línea?</translation>
    </message>
    <message>
        <source>frames that were lost on the wire: {0}; every trigger was taken: plan the link&apos;s budget</source>
        <translation>imágenes perdidas en la red: {0}; se aceptaron todos los disparos: planifique el presupuesto del enlace</translation>
    </message>
    <message>
        <source>actions that did not reach the camera: {0} of {1}; they were lost on the network</source>
        <translation>acciones que no llegaron a la cámara: {0} de {1}; se perdieron en la red</translation>
    </message>
    <message>
        <source>it has no PTP</source>
        <translation>no tiene PTP</translation>
    </message>
    <message>
        <source>PTP is off</source>
        <translation>PTP está desactivado</translation>
    </message>
    <message>
        <source>not locked to a master (PtpStatus {0})</source>
        <translation>no está sincronizada con un maestro (PtpStatus {0})</translation>
    </message>
    <message>
        <source>it follows another PTP master {0} than {1}</source>
        <translation>sigue a otro maestro PTP, {0}, en lugar de {1}</translation>
    </message>
    <message>
        <source>it follows another PTP master than {0}</source>
        <translation>sigue a otro maestro PTP que {0}</translation>
    </message>
    <message>
        <source>the cameras need {0} MB/s, but {1} of the link are {2} MB/s: lower every frame rate to {3} of it, reduce the images, or use a packed pixel format</source>
        <translation>las cámaras necesitan {0} MB/s, pero el {1} del enlace son {2} MB/s: baje todas las frecuencias al {3}, reduzca las imágenes o use un formato de píxel empaquetado</translation>
    </message>
    <message>
        <source>{0} needs {1} MB/s, more than its own cable carries ({2} MB/s)</source>
        <translation>{0} necesita {1} MB/s, más de lo que lleva su propio cable ({2} MB/s)</translation>
    </message>
    <message>
        <source>{0} cannot be paced: {1} kB of a frame would wait in the switch, whose buffer is {2} kB; trigger them one after the other</source>
        <translation>no se puede regular {0}: {1} kB de una imagen esperarían en el conmutador, cuya memoria es de {2} kB; dispárelas una tras otra</translation>
    </message>
    <message>
        <source>{0} is in use by {1}; close it there</source>
        <translation>{1} está usando {0}; ciérrela allí</translation>
    </message>
    <message>
        <source>another program</source>
        <translation>otro programa</translation>
    </message>
    <message>
        <source>a program at {0}</source>
        <translation>un programa en {0}</translation>
    </message>
    <message>
        <source>in use by {0}</source>
        <translation>en uso por {0}</translation>
    </message>
</context>
<context>
    <name>Errors</name>
    <message>
        <source>the connection to {0} was lost</source>
        <translation>se perdió la conexión con {0}</translation>
    </message>
    <message>
        <source>another application controls it</source>
        <translation>otra aplicación la controla</translation>
    </message>
    <message>
        <source>the camera has no {0}</source>
        <translation>la cámara no tiene {0}</translation>
    </message>
    <message>
        <source>{0} does not take this value; allowed: {1}</source>
        <translation>{0} no admite este valor; se permite: {1}</translation>
    </message>
    <message>
        <source>{0} was refused: {1}</source>
        <translation>la cámara rechazó {0}: {1}</translation>
    </message>
    <message>
        <source>{0} was not found; check address, power and cable</source>
        <translation>no se encuentra {0}; compruebe dirección, alimentación y cable</translation>
    </message>
    <message>
        <source>{0} does not answer; check address, power and cable</source>
        <translation>{0} no responde; compruebe dirección, alimentación y cable</translation>
    </message>
    <message>
        <source>no access to {0}: {1}</source>
        <translation>no hay acceso a {0}: {1}</translation>
    </message>
    <message>
        <source>{0} cannot be used on this computer: {1}</source>
        <translation>{0} no se puede usar en este equipo: {1}</translation>
    </message>
    <message>
        <source>the camera does not answer: {0}</source>
        <translation>la cámara no responde: {0}</translation>
    </message>
    <message>
        <source>the connection to the camera was lost: {0}</source>
        <translation>se perdió la conexión con la cámara: {0}</translation>
    </message>
    <message>
        <source>the camera cannot be reached: {0}</source>
        <translation>no se llega a la cámara: {0}</translation>
    </message>
    <message>
        <source>the camera refused it: {0}</source>
        <translation>la cámara lo rechazó: {0}</translation>
    </message>
    <message>
        <source>access denied: {0}</source>
        <translation>acceso denegado: {0}</translation>
    </message>
    <message>
        <source>not found: {0}</source>
        <translation>no encontrado: {0}</translation>
    </message>
    <message>
        <source>this cannot be understood: {0}</source>
        <translation>no se entiende: {0}</translation>
    </message>
    <message>
        <source>{0} may be another camera than the one you named: {1}</source>
        <translation>{0} puede no ser la cámara que indicó: {1}</translation>
    </message>
    <message>
        <source>; and {0} more</source>
        <translation>; y {0} más</translation>
    </message>
    <message>
        <source>set as before</source>
        <translation>ajustada como antes</translation>
    </message>
    <message>
        <source>but not as before: {0}</source>
        <translation>pero no como antes: {0}</translation>
    </message>
    <message>
        <source>; changed meanwhile, not by us: {0}</source>
        <translation>; cambiado entretanto, no por nosotros: {0}</translation>
    </message>
    <message>
        <source>no other application controls it any more</source>
        <translation>ninguna otra aplicación la controla ya</translation>
    </message>
</context>
<context>
    <name>FavouritesController</name>
    <message>
        <source>no more than {0} controls can be pinned; unpin one first</source>
        <translation>no puede haber más de {0} controles fijados; suelte uno antes</translation>
    </message>
</context>
<context>
    <name>FavouritesStrip</name>
    <message>
        <source>Favourites</source>
        <translation>Favoritos</translation>
    </message>
    <message>
        <source>Exposure, gain and frame rate appear here if the camera has them.</source>
        <translation>Aquí aparecen exposición, ganancia y frecuencia, si la cámara las tiene.</translation>
    </message>
    <message>
        <source>Drag the name of a feature here to pin it above the image.</source>
        <translation>Arrastre aquí el nombre de un parámetro para fijarlo sobre la imagen.</translation>
    </message>
</context>
<context>
    <name>FeatureController</name>
    <message>
        <source>Exposure</source>
        <translation>Exposición</translation>
    </message>
    <message>
        <source>Gain</source>
        <translation>Ganancia</translation>
    </message>
    <message>
        <source>Frame rate</source>
        <translation>Frecuencia</translation>
    </message>
</context>
<context>
    <name>FeatureMenuController</name>
    <message>
        <source>&amp;Plot over time</source>
        <translation>&amp;Representar en el tiempo</translation>
    </message>
    <message>
        <source>&amp;Copy the name</source>
        <translation>&amp;Copiar el nombre</translation>
    </message>
    <message>
        <source>Copy name and &amp;value</source>
        <translation>Copiar nombre y &amp;valor</translation>
    </message>
    <message>
        <source>P&amp;in</source>
        <translation>F&amp;ijar</translation>
    </message>
    <message>
        <source>&amp;Unpin</source>
        <translation>&amp;Soltar</translation>
    </message>
    <message>
        <source>Move to the &amp;left</source>
        <translation>Mover a la &amp;izquierda</translation>
    </message>
    <message>
        <source>Move to the ri&amp;ght</source>
        <translation>Mover a la &amp;derecha</translation>
    </message>
    <message>
        <source>Pin t&amp;he usual controls</source>
        <translation>Fijar los controles &amp;habituales</translation>
    </message>
</context>
<context>
    <name>FeaturePanel</name>
    <message>
        <source>Features</source>
        <translation>Parámetros</translation>
    </message>
    <message>
        <source>Show the features whose name or description contains these words</source>
        <translation>Mostrar los parámetros cuyo nombre o descripción contiene estas palabras</translation>
    </message>
    <message>
        <source>Filter features</source>
        <translation>Filtrar parámetros</translation>
    </message>
    <message>
        <source>Filter features…</source>
        <translation>Filtrar parámetros…</translation>
    </message>
    <message>
        <source>How many features to show</source>
        <translation>Cuántos parámetros mostrar</translation>
    </message>
    <message>
        <source>Visibility</source>
        <translation>Nivel</translation>
    </message>
    <message>
        <source>Beginner</source>
        <translation>Básico</translation>
    </message>
    <message>
        <source>Expert</source>
        <translation>Experto</translation>
    </message>
    <message>
        <source>Guru</source>
        <translation>Gurú</translation>
    </message>
    <message>
        <source>The camera&apos;s controls appear here once one is connected.</source>
        <translation>Los controles de la cámara aparecen aquí cuando se conecta una.</translation>
    </message>
    <message>
        <source>{0} more match; type another letter.</source>
        <translation>Coinciden {0} más; escriba otra letra.</translation>
    </message>
    <message>
        <source>Nothing matches.</source>
        <translation>No hay coincidencias.</translation>
    </message>
    <message>
        <source>1 more matches; type another letter.</source>
        <translation>Coincide 1 más; escriba otra letra.</translation>
    </message>
    <message>
        <source>Show the features of every visibility</source>
        <translation>Mostrar las características de cualquier visibilidad</translation>
    </message>
    <message>
        <source>Show {0} more (Guru)</source>
        <translation>Mostrar {0} más (Guru)</translation>
    </message>
</context>
<context>
    <name>Features</name>
    <message>
        <source>is not available: {0}</source>
        <translation>no está disponible: {0}</translation>
    </message>
    <message>
        <source>is not implemented by this camera</source>
        <translation>no existe en esta cámara</translation>
    </message>
    <message>
        <source>is not available at the moment; another feature&apos;s value hides it</source>
        <translation>no está disponible ahora; lo oculta el valor de otro parámetro</translation>
    </message>
    <message>
        <source>is read-only; streaming or another feature may lock it</source>
        <translation>es de solo lectura; puede bloquearlo la captura u otro parámetro</translation>
    </message>
    <message>
        <source>cannot be used at the moment</source>
        <translation>no se puede usar ahora</translation>
    </message>
    <message>
        <source>one of {0}</source>
        <translation>uno de {0}</translation>
    </message>
    <message>
        <source>true or false</source>
        <translation>sí o no</translation>
    </message>
    <message>
        <source>up to {0} bytes of text</source>
        <translation>texto de hasta {0} bytes</translation>
    </message>
    <message>
        <source>text</source>
        <translation>texto</translation>
    </message>
    <message>
        <source>a number</source>
        <translation>un número</translation>
    </message>
    <message>
        <source>{0}, step {1}</source>
        <translation>{0}, paso {1}</translation>
    </message>
    <message>
        <source>yes</source>
        <translation>sí</translation>
    </message>
    <message>
        <source>no</source>
        <translation>no</translation>
    </message>
    <message>
        <source>It {0}.</source>
        <translation>Este parámetro {0}.</translation>
    </message>
    <message>
        <source>Value: {0}</source>
        <translation>Valor: {0}</translation>
    </message>
    <message>
        <source>Range: {0}</source>
        <translation>Rango: {0}</translation>
    </message>
    <message>
        <source>Selected by: {0}</source>
        <translation>Selector: {0}</translation>
    </message>
    <message>
        <source>Changing it pauses the stream for a moment.</source>
        <translation>Cambiarlo detiene la captura un momento.</translation>
    </message>
    <message>
        <source>is read-only</source>
        <translation>es de solo lectura</translation>
    </message>
    <message>
        <source>1 byte of text</source>
        <translation>texto de 1 byte</translation>
    </message>
    <message>
        <source>At least {0}</source>
        <translation>Como mínimo {0}</translation>
    </message>
    <message>
        <source>At most {0}</source>
        <translation>Como máximo {0}</translation>
    </message>
    <message>
        <source>Only in steps of {0}</source>
        <translation>Solo en pasos de {0}</translation>
    </message>
    <message>
        <source>is not available while the camera streams; stop it first</source>
        <translation>no está disponible mientras la cámara transmite; deténgala primero</translation>
    </message>
    <message>
        <source>is read-only while the camera streams; stop it first</source>
        <translation>es de solo lectura mientras la cámara transmite; deténgala primero</translation>
    </message>
    <message>
        <source> and </source>
        <translation> y </translation>
    </message>
    <message>
        <source>{0} is {1}</source>
        <translation>{0} es {1}</translation>
    </message>
    <message>
        <source>is not available at the moment; it depends on other features: {0}</source>
        <translation>no está disponible en este momento; depende de otras características: {0}</translation>
    </message>
    <message>
        <source>is read-only at the moment; it depends on other features: {0}</source>
        <translation>es de solo lectura en este momento; depende de otras características: {0}</translation>
    </message>
    <message>
        <source>{0} to {1}</source>
        <translation>{0} a {1}</translation>
    </message>
    <message>
        <source> or </source>
        <translation> o </translation>
    </message>
    <message>
        <source>is not available while {0}; set {1}</source>
        <translation>no está disponible mientras {0}; ajuste {1}</translation>
    </message>
    <message>
        <source>is read-only while {0}; set {1}</source>
        <translation>es de solo lectura mientras {0}; ajuste {1}</translation>
    </message>
</context>
<context>
    <name>FocusPanel</name>
    <message>
        <source>Sharpness</source>
        <translation>Nitidez</translation>
    </message>
    <message>
        <source>Draw the region to bring into focus</source>
        <translation>Dibujar la región que debe ser nítida</translation>
    </message>
    <message>
        <source>Choose region</source>
        <translation>Elegir región</translation>
    </message>
    <message>
        <source>Score the whole image</source>
        <translation>Valorar toda la imagen</translation>
    </message>
    <message>
        <source>Whole image</source>
        <translation>Toda la imagen</translation>
    </message>
    <message>
        <source>Forget the best score</source>
        <translation>Olvidar el mejor valor</translation>
    </message>
    <message>
        <source>Start again</source>
        <translation>Empezar de nuevo</translation>
    </message>
    <message>
        <source>Sharpness over time</source>
        <translation>Nitidez en el tiempo</translation>
    </message>
    <message>
        <source>Sharpness over the last seconds; dashed: the best</source>
        <translation>Nitidez en los últimos segundos; línea discontinua: la mejor</translation>
    </message>
    <message>
        <source>of the whole image</source>
        <translation>de toda la imagen</translation>
    </message>
    <message>
        <source>Sharpness {0:.2f}    best {1:.2f}    {2:.0%} of the best</source>
        <translation>Nitidez {0:.2f}    mejor {1:.2f}    {2:.0%} de la mejor</translation>
    </message>
    <message>
        <source>Sharpness {0:.2f}    best {1:.2f}</source>
        <translation>Nitidez {0:.2f}    mejor {1:.2f}</translation>
    </message>
</context>
<context>
    <name>FrameData</name>
    <message>
        <source>Frame id</source>
        <translation>Id. del fotograma</translation>
    </message>
    <message>
        <source>Exposed or received at</source>
        <translation>Expuesto o recibido a las</translation>
    </message>
    <message>
        <source>Camera&apos;s clock</source>
        <translation>Reloj de la cámara</translation>
    </message>
    <message>
        <source>Size</source>
        <translation>Tamaño</translation>
    </message>
    <message>
        <source>Pixel format</source>
        <translation>Formato de píxel</translation>
    </message>
    <message>
        <source>Offset</source>
        <translation>Desplazamiento</translation>
    </message>
    <message>
        <source>Payload</source>
        <translation>Datos</translation>
    </message>
    <message>
        <source>{0} bytes</source>
        <translation>{0} bytes</translation>
    </message>
    <message>
        <source>Completeness</source>
        <translation>Integridad</translation>
    </message>
    <message>
        <source>Stream channel</source>
        <translation>Canal de flujo</translation>
    </message>
    <message>
        <source>File</source>
        <translation>Archivo</translation>
    </message>
    <message>
        <source>complete</source>
        <translation>completo</translation>
    </message>
    <message>
        <source>1 byte is missing</source>
        <translation>falta 1 byte</translation>
    </message>
    <message>
        <source>{0} bytes are missing</source>
        <translation>faltan {0} bytes</translation>
    </message>
    <message>
        <source>1 byte</source>
        <translation>1 byte</translation>
    </message>
</context>
<context>
    <name>FrameDataDialog</name>
    <message>
        <source>Data of the shown frame</source>
        <translation>Datos del fotograma mostrado</translation>
    </message>
    <message>
        <source>Data of the frame</source>
        <translation>Datos del fotograma</translation>
    </message>
    <message>
        <source>Name</source>
        <translation>Nombre</translation>
    </message>
    <message>
        <source>Value</source>
        <translation>Valor</translation>
    </message>
    <message>
        <source>Chunk data appears here once ChunkModeActive and the chunks are on.</source>
        <translation>Los datos de chunk aparecen aquí cuando ChunkModeActive y los chunks están activados.</translation>
    </message>
    <message>
        <source>&amp;Copy</source>
        <translation>&amp;Copiar</translation>
    </message>
    <message>
        <source>Close</source>
        <translation>Cerrar</translation>
    </message>
</context>
<context>
    <name>FramesToRecordController</name>
    <message>
        <source>&amp;All frames</source>
        <translation>&amp;Todas las imágenes</translation>
    </message>
    <message>
        <source>&amp;Every n-th frame…</source>
        <translation>&amp;Una de cada n…</translation>
    </message>
    <message>
        <source>&amp;Time-lapse…</source>
        <translation>&amp;Cámara rápida…</translation>
    </message>
    <message>
        <source>Record one of so many frames:</source>
        <translation>Grabar una de cada tantas imágenes:</translation>
    </message>
    <message>
        <source>Record a frame every so many seconds:</source>
        <translation>Grabar una imagen cada tantos segundos:</translation>
    </message>
    <message>
        <source>Frames to record</source>
        <translation>Imágenes que grabar</translation>
    </message>
</context>
<context>
    <name>Gallery</name>
    <message>
        <source>Open sources</source>
        <translation>Fuentes abiertas</translation>
    </message>
</context>
<context>
    <name>HandEye</name>
    <message>
        <source>the result could not be saved as {0}: {1}</source>
        <translation>no se pudo guardar el resultado como {0}: {1}</translation>
    </message>
    <message>
        <source>Stopped</source>
        <translation>Parado</translation>
    </message>
    <message>
        <source>the target is not seen</source>
        <translation>no se ve el objetivo</translation>
    </message>
    <message>
        <source>no images arrive from the camera</source>
        <translation>no llegan imágenes de la cámara</translation>
    </message>
    <message>
        <source>internal error, see the log: {0}</source>
        <translation>error interno, véase el registro: {0}</translation>
    </message>
    <message>
        <source>&lt;b&gt;{0} will move by itself&lt;/b&gt; to {1} poses, one after another, for {2}.</source>
        <translation>&lt;b&gt;{0} se moverá por sí mismo&lt;/b&gt; a {1} posturas, una tras otra, durante {2}.</translation>
    </message>
    <message>
        <source>The head turns at up to {0:.0f} °/s; the arm rests.</source>
        <translation>La cabeza gira a un máximo de {0:.0f} °/s; el brazo reposa.</translation>
    </message>
    <message>
        <source>Pan stays within {0}° to {1}°, tilt within {2}° to {3}°.</source>
        <translation>El giro queda entre {0}° y {1}°, la inclinación entre {2}° y {3}°.</translation>
    </message>
    <message>
        <source>The hand moves at up to {0:.0f} mm/s, first by {1} small moves of at most {2:.0f}°.</source>
        <translation>La mano se mueve a un máximo de {0:.0f} mm/s, primero con {1} movimientos pequeños de {2:.0f}° como mucho.</translation>
    </message>
    <message>
        <source>Each joint stays within {0:.0f}° of where it is now.</source>
        <translation>Cada articulación queda a menos de {0:.0f}° de donde está ahora.</translation>
    </message>
    <message>
        <source>The hand stays within x {0} to {1}, y {2} to {3}, z {4} to {5} m in the base.</source>
        <translation>La mano queda entre x {0} y {1}, y {2} y {3}, z {4} y {5} m en la base.</translation>
    </message>
    <message>
        <source>The robot&apos;s body is not known: only the workspace is checked.</source>
        <translation>No se conoce el cuerpo del robot: solo se comprueba el espacio de trabajo.</translation>
    </message>
    <message>
        <source>The arm keeps {0:.0f} mm away from body and configured obstacles.</source>
        <translation>El brazo se mantiene a {0:.0f} mm del cuerpo y de los obstáculos configurados.</translation>
    </message>
    <message>
        <source>&lt;b&gt;The camera is not calibrated&lt;/b&gt;: calibrate it first, or the result is rough.</source>
        <translation>&lt;b&gt;La cámara no está calibrada&lt;/b&gt;: calíbrela primero, o el resultado será aproximado.</translation>
    </message>
    <message>
        <source>Space, Escape and the stop button stop it at once, from any of its windows.</source>
        <translation>Espacio, Escape y el botón de parada lo paran de inmediato, desde cualquiera de sus ventanas.</translation>
    </message>
    <message>
        <source>about {0} s</source>
        <translation>aprox. {0} s</translation>
    </message>
    <message>
        <source>about {0} min</source>
        <translation>aprox. {0} min</translation>
    </message>
    <message>
        <source>moving to pose {0}</source>
        <translation>yendo a la postura {0}</translation>
    </message>
    <message>
        <source>pose {0} taken</source>
        <translation>postura {0} tomada</translation>
    </message>
    <message>
        <source>computing the result</source>
        <translation>calculando el resultado</translation>
    </message>
    <message>
        <source>known to {0:.1f} mm and {1:.2f}°</source>
        <translation>conocida a {0:.1f} mm y {1:.2f}°</translation>
    </message>
    <message>
        <source>skipped: {0}</source>
        <translation>omitida: {0}</translation>
    </message>
    <message>
        <source>the gate refuses it</source>
        <translation>la compuerta de seguridad la rechaza</translation>
    </message>
    <message>
        <source>it was not reached</source>
        <translation>no se alcanzó</translation>
    </message>
    <message>
        <source>the target is not seen reliably</source>
        <translation>el objetivo no se ve con seguridad</translation>
    </message>
    <message>
        <source>the robot did not come to rest</source>
        <translation>el robot no estaba en reposo</translation>
    </message>
    <message>
        <source>{0}. The robot stands still. {1} poses were taken: compute from them, or start again</source>
        <translation>{0}. El robot está quieto. Se tomaron {1} posturas: calcule con ellas o empiece de nuevo</translation>
    </message>
    <message>
        <source>Known to</source>
        <translation>Conocida a</translation>
    </message>
    <message>
        <source>x, y, z (mm)</source>
        <translation>x, y, z (mm)</translation>
    </message>
    <message>
        <source>Roll, pitch, yaw (°)</source>
        <translation>Alabeo, cabeceo, guiñada (°)</translation>
    </message>
    <message>
        <source>Residual</source>
        <translation>Residuo</translation>
    </message>
    <message>
        <source>{0:.3f} px over {1} of {2} poses</source>
        <translation>{0:.3f} px en {1} de {2} posturas</translation>
    </message>
    <message>
        <source>Method</source>
        <translation>Método</translation>
    </message>
    <message>
        <source>{0}, refined with all corners together</source>
        <translation>{0}, refinado con todas las esquinas a la vez</translation>
    </message>
    <message>
        <source>Joint offsets</source>
        <translation>Desfases</translation>
    </message>
    <message>
        <source>the calibration in use</source>
        <translation>la calibración en uso</translation>
    </message>
    <message>
        <source>the robot&apos;s model, which is in use</source>
        <translation>el modelo del robot, que está en uso</translation>
    </message>
    <message>
        <source>{0:.1f} mm and {1:.2f}° from {2}</source>
        <translation>{0:.1f} mm y {1:.2f}° de {2}</translation>
    </message>
    <message>
        <source>{0}. The robot stands still. Poses taken: {1}; needed: {2}. Start again</source>
        <translation>{0}. El robot está quieto. Posturas tomadas: {1}; necesarias: {2}. Empiece de nuevo</translation>
    </message>
</context>
<context>
    <name>HandEyeController</name>
    <message>
        <source>name both frames: what the camera is mounted on, and the camera&apos;s own</source>
        <translation>nombre ambos sistemas de referencia: el del soporte de la cámara y el de la cámara</translation>
    </message>
    <message>
        <source>Save the robot&apos;s file</source>
        <translation>Guardar el archivo del robot</translation>
    </message>
    <message>
        <source>Servoing uses a camera on the head; save this result or publish it</source>
        <translation>El servocontrol usa una cámara en la cabeza; guarde este resultado o publíquelo</translation>
    </message>
    <message>
        <source>Saved as {0}. Use it with `grabbergui servo … --hand-eye {0}`</source>
        <translation>Guardado como {0}. Úselo con `grabbergui servo … --hand-eye {0}`</translation>
    </message>
</context>
<context>
    <name>HandEyeDialog</name>
    <message>
        <source>Calibrate hand and eye</source>
        <translation>Calibrar mano y ojo</translation>
    </message>
    <message>
        <source>EMERGENCY STOP</source>
        <translation>PARADA DE EMERGENCIA</translation>
    </message>
    <message>
        <source>Stops the robot at once (Escape; Space while it moves)</source>
        <translation>Para el robot de inmediato (Escape; Espacio mientras se mueve)</translation>
    </message>
    <message>
        <source>Live image</source>
        <translation>Imagen en directo</translation>
    </message>
    <message>
        <source>● waiting for an image</source>
        <translation>● esperando una imagen</translation>
    </message>
    <message>
        <source>Camera on the &amp;head, board fixed</source>
        <translation>Cámara en la ca&amp;beza, tablero fijo</translation>
    </message>
    <message>
        <source>The head turns and looks at a fixed board</source>
        <translation>La cabeza gira y mira un tablero fijo</translation>
    </message>
    <message>
        <source>Camera on the h&amp;and, board fixed</source>
        <translation>Cámara en la &amp;mano, tablero fijo</translation>
    </message>
    <message>
        <source>The hand moves around a fixed board</source>
        <translation>La mano se mueve alrededor de un tablero fijo</translation>
    </message>
    <message>
        <source>Camera fixed, &amp;board in the hand</source>
        <translation>Cámara &amp;fija, tablero en la mano</translation>
    </message>
    <message>
        <source>The camera is fixed; the hand moves the board in front of it</source>
        <translation>La cámara está fija; la mano mueve el tablero delante de ella</translation>
    </message>
    <message>
        <source>B&amp;oard</source>
        <translation>&amp;Tablero</translation>
    </message>
    <message>
        <source>One marker</source>
        <translation>Un marcador</translation>
    </message>
    <message>
        <source>Grid of markers</source>
        <translation>Cuadrícula de marcadores</translation>
    </message>
    <message>
        <source>ChArUco</source>
        <translation>ChArUco</translation>
    </message>
    <message>
        <source>&amp;Dictionary</source>
        <translation>&amp;Diccionario</translation>
    </message>
    <message>
        <source>N&amp;umber</source>
        <translation>&amp;Número</translation>
    </message>
    <message>
        <source>The marker&apos;s number, or the first one on the board</source>
        <translation>El número del marcador, o el primero del tablero</translation>
    </message>
    <message>
        <source>A&amp;cross, down</source>
        <translation>Anc&amp;ho, alto</translation>
    </message>
    <message>
        <source>Markers of a grid, or squares of a ChArUco board, in a row</source>
        <translation>Marcadores de una cuadrícula, o casillas de un tablero ChArUco, a lo ancho</translation>
    </message>
    <message>
        <source>Number of rows</source>
        <translation>Número de filas</translation>
    </message>
    <message>
        <source>Down</source>
        <translation>Alto</translation>
    </message>
    <message>
        <source>&amp;Marker, pitch</source>
        <translation>Ma&amp;rcador, paso</translation>
    </message>
    <message>
        <source>Edge of a marker&apos;s black square, as measured on the paper</source>
        <translation>Lado del cuadrado negro de un marcador, medido en el papel</translation>
    </message>
    <message>
        <source> mm</source>
        <translation> mm</translation>
    </message>
    <message>
        <source>Distance between the markers of a grid; edge of a ChArUco square</source>
        <translation>De marcador a marcador de una cuadrícula; lado de una casilla ChArUco</translation>
    </message>
    <message>
        <source>Pitch</source>
        <translation>Paso</translation>
    </message>
    <message>
        <source>&amp;Poses, speed</source>
        <translation>&amp;Posturas, veloc.</translation>
    </message>
    <message>
        <source>Number of poses from which the robot looks at the board</source>
        <translation>Desde cuántas posturas mira el robot el tablero</translation>
    </message>
    <message>
        <source> %</source>
        <translation> %</translation>
    </message>
    <message>
        <source>All motion is slowed down to this share of its speed</source>
        <translation>Todo movimiento se frena a esta parte de su velocidad</translation>
    </message>
    <message>
        <source>Speed</source>
        <translation>Velocidad</translation>
    </message>
    <message>
        <source>&amp;Take the printed calibration board</source>
        <translation>&amp;Usar el tablero de calibración impreso</translation>
    </message>
    <message>
        <source>The board that Calibrate camera saves for printing: ChArUco, 8 × 6 squares of 30 mm</source>
        <translation>El tablero que Calibrar cámara guarda para imprimir: ChArUco, 8 × 6 casillas de 30 mm</translation>
    </message>
    <message>
        <source>Nobody is within reach of the robot</source>
        <translation>No hay nadie al alcance del robot</translation>
    </message>
    <message>
        <source>Nobody is within the robot&apos;s reach, and its own emergency stop is within mine.</source>
        <translation>No hay nadie al alcance del robot, y su propia parada de emergencia está al mío.</translation>
    </message>
    <message>
        <source>%v of %m poses</source>
        <translation>%v de %m posturas</translation>
    </message>
    <message>
        <source>Events</source>
        <translation>Sucesos</translation>
    </message>
    <message>
        <source>Time</source>
        <translation>Tiempo</translation>
    </message>
    <message>
        <source>Event</source>
        <translation>Suceso</translation>
    </message>
    <message>
        <source>Poses</source>
        <translation>Posturas</translation>
    </message>
    <message>
        <source>Pose</source>
        <translation>Post.</translation>
    </message>
    <message>
        <source>Residual</source>
        <translation>Residuo</translation>
    </message>
    <message>
        <source>Joints, °</source>
        <translation>Articulaciones, °</translation>
    </message>
    <message>
        <source>&amp;Frames</source>
        <translation>S&amp;istemas</translation>
    </message>
    <message>
        <source>Name in tf of the frame on which the camera is mounted</source>
        <translation>Nombre en tf del soporte de la cámara</translation>
    </message>
    <message>
        <source>Frame of the camera</source>
        <translation>Sistema de la cámara</translation>
    </message>
    <message>
        <source>Name in tf of the camera&apos;s optical frame</source>
        <translation>Nombre en tf del sistema óptico de la cámara</translation>
    </message>
    <message>
        <source>&amp;Use now</source>
        <translation>&amp;Usar ahora</translation>
    </message>
    <message>
        <source>Publish in &amp;tf</source>
        <translation>Publicar en &amp;tf</translation>
    </message>
    <message>
        <source>On /tf_static over ROS 2, until this window&apos;s program ends or this button is released</source>
        <translation>En /tf_static por ROS 2, hasta que termine el programa de esta ventana o se suelte este botón</translation>
    </message>
    <message>
        <source>Bac&amp;k</source>
        <translation>&amp;Atrás</translation>
    </message>
    <message>
        <source>Close</source>
        <translation>Cerrar</translation>
    </message>
    <message>
        <source>&amp;Next</source>
        <translation>&amp;Siguiente</translation>
    </message>
    <message>
        <source>Setup</source>
        <translation>Preparación</translation>
    </message>
    <message>
        <source>Plan</source>
        <translation>Plan</translation>
    </message>
    <message>
        <source>Motion</source>
        <translation>Movimiento</translation>
    </message>
    <message>
        <source>Result</source>
        <translation>Resultado</translation>
    </message>
    <message>
        <source>&amp;Let the robot move</source>
        <translation>&amp;Mover el robot</translation>
    </message>
    <message>
        <source>C&amp;ompute</source>
        <translation>&amp;Calcular</translation>
    </message>
    <message>
        <source>&amp;Save…</source>
        <translation>&amp;Guardar…</translation>
    </message>
    <message>
        <source>Start a&amp;gain</source>
        <translation>&amp;Empezar de nuevo</translation>
    </message>
    <message>
        <source>Starting</source>
        <translation>Empezando</translation>
    </message>
    <message>
        <source>Where is the camera of &lt;b&gt;{0}&lt;/b&gt;?</source>
        <translation>¿Dónde está la cámara de &lt;b&gt;{0}&lt;/b&gt;?</translation>
    </message>
    <message>
        <source>the target is seen</source>
        <translation>se ve el objetivo</translation>
    </message>
    <message>
        <source>{0} left</source>
        <translation>quedan {0}</translation>
    </message>
    <message>
        <source>No other calibration of this camera is known</source>
        <translation>No se conoce otra calibración de esta cámara</translation>
    </message>
    <message>
        <source>Differs by {0}</source>
        <translation>Difiere en {0}</translation>
    </message>
    <message>
        <source>left out</source>
        <translation>excluida</translation>
    </message>
    <message>
        <source>Use this result for servoing instead of the previous one</source>
        <translation>Usar este resultado para el servocontrol en lugar del anterior</translation>
    </message>
    <message>
        <source>In &amp;use</source>
        <translation>En &amp;uso</translation>
    </message>
    <message>
        <source>On &amp;tf</source>
        <translation>En &amp;tf</translation>
    </message>
    <message>
        <source>Bring the board into the middle of the image; it must not move on its own.</source>
        <translation>Lleve el tablero al centro de la imagen; no debe moverse por sí solo.</translation>
    </message>
</context>
<context>
    <name>HistogramPanel</name>
    <message>
        <source>Mean, saturated and black</source>
        <translation>Media, saturado y negro</translation>
    </message>
    <message>
        <source>Counts on a logarithmic scale</source>
        <translation>Recuento en escala logarítmica</translation>
    </message>
    <message>
        <source>&amp;Log</source>
        <translation>&amp;Log.</translation>
    </message>
    <message>
        <source>Show the sensor’s whole range again</source>
        <translation>Mostrar de nuevo todo el rango del sensor</translation>
    </message>
    <message>
        <source>Whole range</source>
        <translation>Todo el rango</translation>
    </message>
    <message>
        <source>Histogram</source>
        <translation>Histograma</translation>
    </message>
    <message>
        <source>Stretch the levels over 99 % of the image; the camera and saved frames do not change</source>
        <translation>Mostrar de negro a blanco lo que ocupa el 99 % de la imagen; la cámara y lo que se guarda no cambian</translation>
    </message>
    <message>
        <source>Fit levels</source>
        <translation>Ajustar niveles</translation>
    </message>
    <message>
        <source>Mean {0}    {1:.2%} saturated    {2:.2%} black</source>
        <translation>Media {0}    {1:.2%} saturado    {2:.2%} negro</translation>
    </message>
    <message>
        <source>grey</source>
        <translation>gris</translation>
    </message>
</context>
<context>
    <name>Image</name>
    <message>
        <source>frame {0} ({1}) cannot be shown: {2}</source>
        <translation>no se puede mostrar el fotograma {0} ({1}): {2}</translation>
    </message>
    <message>
        <source>no data</source>
        <translation>sin datos</translation>
    </message>
</context>
<context>
    <name>ImageNote</name>
    <message>
        <source>The stages of an image, and where it is lost</source>
        <translation>Las etapas de una imagen, y dónde se pierde</translation>
    </message>
    <message>
        <source>control</source>
        <translation>control</translation>
    </message>
    <message>
        <source>packets</source>
        <translation>paquetes</translation>
    </message>
    <message>
        <source>frames</source>
        <translation>imágenes</translation>
    </message>
    <message>
        <source>conversion</source>
        <translation>conversión</translation>
    </message>
    <message>
        <source>display</source>
        <translation>pantalla</translation>
    </message>
</context>
<context>
    <name>ImageView</name>
    <message>
        <source>Live image</source>
        <translation>Imagen en directo</translation>
    </message>
    <message>
        <source>Pixel under the cursor and the sensor&apos;s value there</source>
        <translation>Píxel bajo el cursor y el valor del sensor en él</translation>
    </message>
    <message>
        <source>Pixel under the cursor</source>
        <translation>Píxel bajo el cursor</translation>
    </message>
    <message>
        <source>What to do</source>
        <translation>Qué hacer</translation>
    </message>
    <message>
        <source>Draw the region that the camera should send; Esc cancels.</source>
        <translation>Dibuje la región que la cámara debe enviar; Esc cancela.</translation>
    </message>
    <message>
        <source>Draw the region to bring into focus; Esc cancels.</source>
        <translation>Dibuje la región que debe ser nítida; Esc cancela.</translation>
    </message>
    <message>
        <source>Draw the line whose values you want to see; Esc cancels.</source>
        <translation>Dibuje la línea cuyos valores se mostrarán; Esc cancela.</translation>
    </message>
    <message>
        <source>Draw the region whose brightness counts; Esc cancels.</source>
        <translation>Dibuje la región cuyo brillo cuenta; Esc cancela.</translation>
    </message>
    <message>
        <source>Draw a region that should be grey; Esc cancels.</source>
        <translation>Dibuje una región que debería ser gris; Esc cancela.</translation>
    </message>
    <message>
        <source>Last image, {0} old</source>
        <translation>Última imagen, de hace {0}</translation>
    </message>
    <message>
        <source>Component of the frame</source>
        <translation>Componente del fotograma</translation>
    </message>
    <message>
        <source>Which of the images in each frame is shown</source>
        <translation>Cuál de las imágenes de cada fotograma se muestra</translation>
    </message>
    <message>
        <source>Side by side</source>
        <translation>Lado a lado</translation>
    </message>
    <message>
        <source>Show all images of each frame at once; zoom, position and cursor are common to all. A click on one makes it the current one.</source>
        <translation>Muestra a la vez todas las imágenes de cada fotograma; el aumento, la posición y el cursor son comunes a todas. Con un clic en una, pasa a ser la actual.</translation>
    </message>
    <message>
        <source>Draw a line; Esc cancels.</source>
        <translation>Dibuje una línea; Esc cancela.</translation>
    </message>
    <message>
        <source>Draw a region; Esc cancels.</source>
        <translation>Dibuje una región; Esc cancela.</translation>
    </message>
    <message>
        <source>Draw a region, or drag the handles of this one; Esc ends.</source>
        <translation>Dibuje una región o arrastre los tiradores de esta; Esc termina.</translation>
    </message>
    <message>
        <source>Draw, or drag handles; Esc ends.</source>
        <translation>Dibuje o arrastre; Esc termina.</translation>
    </message>
</context>
<context>
    <name>IpAddress</name>
    <message>
        <source>The camera has the address {0}, also after its next start.</source>
        <translation>La cámara tiene la dirección {0}, también tras su próximo arranque.</translation>
    </message>
    <message>
        <source>The camera has the address {0} until it is switched off.</source>
        <translation>La cámara tiene la dirección {0} hasta que se apague.</translation>
    </message>
</context>
<context>
    <name>IpAddressController</name>
    <message>
        <source>Its address is {0}.</source>
        <translation>Su dirección es {0}.</translation>
    </message>
</context>
<context>
    <name>IpAddressDialog</name>
    <message>
        <source>IP address of the camera</source>
        <translation>Dirección IP de la cámara</translation>
    </message>
    <message>
        <source>&amp;Address</source>
        <translation>&amp;Dirección</translation>
    </message>
    <message>
        <source>Subnet &amp;mask</source>
        <translation>&amp;Máscara de subred</translation>
    </message>
    <message>
        <source>&amp;Gateway</source>
        <translation>&amp;Puerta de enlace</translation>
    </message>
    <message>
        <source>none</source>
        <translation>ninguna</translation>
    </message>
    <message>
        <source>Write it as the persistent address; otherwise the camera has it until it is switched off</source>
        <translation>Escribirla como dirección persistente; si no, la cámara la tiene hasta que se apague</translation>
    </message>
    <message>
        <source>&amp;Keep it after power-off (persistent IP)</source>
        <translation>&amp;Conservarla tras apagar (IP persistente)</translation>
    </message>
    <message>
        <source>&amp;Set the address</source>
        <translation>&amp;Asignar la dirección</translation>
    </message>
    <message>
        <source>Close</source>
        <translation>Cerrar</translation>
    </message>
    <message>
        <source>Waiting for the camera…</source>
        <translation>Esperando a la cámara…</translation>
    </message>
</context>
<context>
    <name>LastFramesController</name>
    <message>
        <source>there is no frame to save yet; start the camera first</source>
        <translation>todavía no hay ningún fotograma que guardar; inicie antes la cámara</translation>
    </message>
    <message>
        <source>Saving the last {0} frames</source>
        <translation>Guardando los últimos {0} fotogramas</translation>
    </message>
    <message>
        <source>Saving the last frame</source>
        <translation>Guardando el último fotograma</translation>
    </message>
</context>
<context>
    <name>LogPanel</name>
    <message>
        <source>The lowest level of the entries to show</source>
        <translation>Las entradas menos graves que se muestran</translation>
    </message>
    <message>
        <source>Lowest level</source>
        <translation>Nivel mínimo</translation>
    </message>
    <message>
        <source>Everything</source>
        <translation>Todo</translation>
    </message>
    <message>
        <source>Warnings and errors</source>
        <translation>Avisos y errores</translation>
    </message>
    <message>
        <source>Errors</source>
        <translation>Errores</translation>
    </message>
    <message>
        <source>Copy what is shown</source>
        <translation>Copiar lo que se muestra</translation>
    </message>
    <message>
        <source>Copy</source>
        <translation>Copiar</translation>
    </message>
    <message>
        <source>Forget all entries</source>
        <translation>Olvidar todas las entradas</translation>
    </message>
    <message>
        <source>Clear</source>
        <translation>Vaciar</translation>
    </message>
    <message>
        <source>Log</source>
        <translation>Registro</translation>
    </message>
    <message>
        <source>Messages of the program and its drivers appear here.</source>
        <translation>Aquí aparece lo que dicen el programa y sus controladores.</translation>
    </message>
</context>
<context>
    <name>LutController</name>
    <message>
        <source>Reading the look-up table</source>
        <translation>Leyendo la tabla de consulta</translation>
    </message>
    <message>
        <source>Tables (*.csv *.txt *.bin *.raw);;All files (*)</source>
        <translation>Tablas (*.csv *.txt *.bin *.raw);;Todos los archivos (*)</translation>
    </message>
    <message>
        <source>Load a look-up table</source>
        <translation>Cargar una tabla de consulta</translation>
    </message>
    <message>
        <source>Comma-separated values (*.csv);;16-bit values (*.bin)</source>
        <translation>Valores separados por comas (*.csv);;Valores de 16 bits (*.bin)</translation>
    </message>
    <message>
        <source>Save the look-up table</source>
        <translation>Guardar la tabla de consulta</translation>
    </message>
    <message>
        <source>Saved {0}</source>
        <translation>Se guardó {0}</translation>
    </message>
    <message>
        <source>The camera has the new look-up table</source>
        <translation>La cámara tiene la nueva tabla de consulta</translation>
    </message>
    <message>
        <source>Writing the look-up table</source>
        <translation>Escribiendo la tabla de consulta</translation>
    </message>
    <message>
        <source>Switching the look-up table</source>
        <translation>Conmutando la tabla de consulta</translation>
    </message>
</context>
<context>
    <name>LutDialog</name>
    <message>
        <source>Look-up table</source>
        <translation>Tabla de consulta</translation>
    </message>
    <message>
        <source>&amp;Table</source>
        <translation>&amp;Tabla</translation>
    </message>
    <message>
        <source>The camera &amp;uses it</source>
        <translation>La cámara la &amp;usa</translation>
    </message>
    <message>
        <source>Curve of the look-up table</source>
        <translation>Curva de la tabla de consulta</translation>
    </message>
    <message>
        <source>Horizontal: value of the sensor; vertical: value that is sent instead</source>
        <translation>A la derecha: valor del sensor; hacia arriba: valor que se envía en su lugar</translation>
    </message>
    <message>
        <source>Gamma</source>
        <translation>Gamma</translation>
    </message>
    <message>
        <source>Below 1, dark parts become brighter; above 1, darker</source>
        <translation>Por debajo de 1, las partes oscuras se aclaran; por encima de 1, se oscurecen</translation>
    </message>
    <message>
        <source>&amp;Gamma</source>
        <translation>G&amp;amma</translation>
    </message>
    <message>
        <source>Li&amp;near</source>
        <translation>Li&amp;neal</translation>
    </message>
    <message>
        <source>L&amp;oad…</source>
        <translation>Ca&amp;rgar…</translation>
    </message>
    <message>
        <source>&amp;Save…</source>
        <translation>&amp;Guardar…</translation>
    </message>
    <message>
        <source>Un&amp;do</source>
        <translation>&amp;Deshacer</translation>
    </message>
    <message>
        <source>Write back the camera&apos;s previous table</source>
        <translation>Vuelve a escribir la tabla que la cámara tenía antes</translation>
    </message>
    <message>
        <source>&amp;Write to the camera</source>
        <translation>&amp;Escribir en la cámara</translation>
    </message>
    <message>
        <source>&amp;Close</source>
        <translation>&amp;Cerrar</translation>
    </message>
    <message>
        <source>{0} entries</source>
        <translation>{0} valores</translation>
    </message>
    <message>
        <source>not written yet</source>
        <translation>aún sin escribir</translation>
    </message>
    <message>
        <source>as in the camera</source>
        <translation>como la tiene la cámara</translation>
    </message>
    <message>
        <source>Input (LUTIndex)</source>
        <translation>Entrada (LUTIndex)</translation>
    </message>
    <message>
        <source>Output (LUTValue)</source>
        <translation>Salida (LUTValue)</translation>
    </message>
    <message>
        <source>in the camera</source>
        <translation>en la cámara</translation>
    </message>
    <message>
        <source>edited</source>
        <translation>editada</translation>
    </message>
    <message>
        <source>Discard the edited table?</source>
        <translation>¿Descartar la tabla editada?</translation>
    </message>
    <message>
        <source>It is neither in the camera nor saved in a file.</source>
        <translation>No está en la cámara ni guardada en un archivo.</translation>
    </message>
    <message>
        <source>&amp;Discard</source>
        <translation>&amp;Descartar</translation>
    </message>
</context>
<context>
    <name>MainWindow</name>
    <message>
        <source>grabbergui</source>
        <translation>grabbergui</translation>
    </message>
    <message>
        <source>&amp;Camera</source>
        <translation>&amp;Cámara</translation>
    </message>
    <message>
        <source>&amp;Edit</source>
        <translation>&amp;Editar</translation>
    </message>
    <message>
        <source>&amp;Image</source>
        <translation>&amp;Imagen</translation>
    </message>
    <message>
        <source>&amp;View</source>
        <translation>&amp;Ver</translation>
    </message>
    <message>
        <source>&amp;Theme</source>
        <translation>&amp;Tema</translation>
    </message>
    <message>
        <source>&amp;Tools</source>
        <translation>&amp;Herramientas</translation>
    </message>
    <message>
        <source>&amp;Help</source>
        <translation>A&amp;yuda</translation>
    </message>
    <message>
        <source>Tools</source>
        <translation>Herramientas</translation>
    </message>
    <message>
        <source>Sources</source>
        <translation>Fuentes</translation>
    </message>
    <message>
        <source>Features</source>
        <translation>Parámetros</translation>
    </message>
    <message>
        <source>Histogram</source>
        <translation>Histograma</translation>
    </message>
    <message>
        <source>Focus aid</source>
        <translation>Ayuda de enfoque</translation>
    </message>
    <message>
        <source>Line profile</source>
        <translation>Perfil de línea</translation>
    </message>
    <message>
        <source>Values over time</source>
        <translation>Valores en el tiempo</translation>
    </message>
    <message>
        <source>Changes</source>
        <translation>Cambios</translation>
    </message>
    <message>
        <source>Log</source>
        <translation>Registro</translation>
    </message>
    <message>
        <source>&amp;Undo</source>
        <translation>&amp;Deshacer</translation>
    </message>
    <message>
        <source>Undo the last change</source>
        <translation>Deshacer el último cambio</translation>
    </message>
    <message>
        <source>Ctrl+Z</source>
        <translation>Ctrl+Z</translation>
    </message>
    <message>
        <source>&amp;Redo</source>
        <translation>&amp;Rehacer</translation>
    </message>
    <message>
        <source>Redo the change that was undone last</source>
        <translation>Rehacer lo que se deshizo</translation>
    </message>
    <message>
        <source>Ctrl+Shift+Z</source>
        <translation>Ctrl+Shift+Z</translation>
    </message>
    <message>
        <source>&amp;Connect</source>
        <translation>&amp;Conectar</translation>
    </message>
    <message>
        <source>Connect to the chosen source</source>
        <translation>Conectar con la fuente elegida</translation>
    </message>
    <message>
        <source>Ctrl+K</source>
        <translation>Ctrl+K</translation>
    </message>
    <message>
        <source>&amp;Disconnect</source>
        <translation>Descon&amp;ectar</translation>
    </message>
    <message>
        <source>Close the current source</source>
        <translation>Soltar la cámara</translation>
    </message>
    <message>
        <source>Ctrl+D</source>
        <translation>Ctrl+D</translation>
    </message>
    <message>
        <source>Open &amp;beside</source>
        <translation>Abrir al &amp;lado</translation>
    </message>
    <message>
        <source>Open the chosen source in a tile; the current one stays open</source>
        <translation>Abrir la fuente elegida en una miniatura y dejar la otra como está</translation>
    </message>
    <message>
        <source>Ctrl+B</source>
        <translation>Ctrl+B</translation>
    </message>
    <message>
        <source>Make the next open source the current one</source>
        <translation>Hacer activa la siguiente de las fuentes abiertas</translation>
    </message>
    <message>
        <source>F10</source>
        <translation>F10</translation>
    </message>
    <message>
        <source>&amp;Start</source>
        <translation>&amp;Iniciar</translation>
    </message>
    <message>
        <source>Start streaming</source>
        <translation>Iniciar la adquisición</translation>
    </message>
    <message>
        <source>F6</source>
        <translation>F6</translation>
    </message>
    <message>
        <source>S&amp;top</source>
        <translation>&amp;Parar</translation>
    </message>
    <message>
        <source>Stop streaming</source>
        <translation>Parar la adquisición</translation>
    </message>
    <message>
        <source>F7</source>
        <translation>F7</translation>
    </message>
    <message>
        <source>S&amp;napshot</source>
        <translation>Cap&amp;turar</translation>
    </message>
    <message>
        <source>Ctrl+S</source>
        <translation>Ctrl+S</translation>
    </message>
    <message>
        <source>Snapshot &amp;folder…</source>
        <translation>&amp;Carpeta de capturas…</translation>
    </message>
    <message>
        <source>Choose where snapshots go</source>
        <translation>Elegir dónde se guardan las capturas</translation>
    </message>
    <message>
        <source>&amp;Record or stop recording</source>
        <translation>&amp;Grabar o dejar de grabar</translation>
    </message>
    <message>
        <source>Ctrl+R</source>
        <translation>Ctrl+R</translation>
    </message>
    <message>
        <source>Ctrl+Shift+S</source>
        <translation>Ctrl+Shift+S</translation>
    </message>
    <message>
        <source>Save all settings of the camera to a file</source>
        <translation>Guardar todos los ajustes de la cámara en un archivo</translation>
    </message>
    <message>
        <source>&amp;Load settings…</source>
        <translation>Cargar a&amp;justes…</translation>
    </message>
    <message>
        <source>Ctrl+Shift+O</source>
        <translation>Ctrl+Shift+O</translation>
    </message>
    <message>
        <source>Load settings from a file, and show the outcome of each</source>
        <translation>Ajustar la cámara según un archivo y mostrar qué ha sido de cada ajuste</translation>
    </message>
    <message>
        <source>Co&amp;mpare with settings…</source>
        <translation>C&amp;omparar con ajustes…</translation>
    </message>
    <message>
        <source>Show what loading a file would change</source>
        <translation>Mostrar qué cambiaría al cargar un archivo</translation>
    </message>
    <message>
        <source>&amp;Quit</source>
        <translation>&amp;Salir</translation>
    </message>
    <message>
        <source>Ctrl+Q</source>
        <translation>Ctrl+Q</translation>
    </message>
    <message>
        <source>&amp;Fit</source>
        <translation>&amp;Encajar</translation>
    </message>
    <message>
        <source>Show the whole image</source>
        <translation>Mostrar toda la imagen</translation>
    </message>
    <message>
        <source>F</source>
        <translation>F</translation>
    </message>
    <message>
        <source>&amp;1:1</source>
        <translation>&amp;1:1</translation>
    </message>
    <message>
        <source>One screen pixel for each pixel of the image</source>
        <translation>Un píxel de pantalla por cada píxel de la imagen</translation>
    </message>
    <message>
        <source>1</source>
        <translation>1</translation>
    </message>
    <message>
        <source>Zoom &amp;in</source>
        <translation>&amp;Ampliar</translation>
    </message>
    <message>
        <source>Zoom in; the mouse wheel does too</source>
        <translation>Ampliar; también con la rueda del ratón</translation>
    </message>
    <message>
        <source>Ctrl++</source>
        <translation>Ctrl++</translation>
    </message>
    <message>
        <source>Zoom &amp;out</source>
        <translation>Re&amp;ducir</translation>
    </message>
    <message>
        <source>Zoom out</source>
        <translation>Reducir</translation>
    </message>
    <message>
        <source>Ctrl+-</source>
        <translation>Ctrl+-</translation>
    </message>
    <message>
        <source>&amp;Pause</source>
        <translation>&amp;Pausa</translation>
    </message>
    <message>
        <source>Pause the image; the last frames can be stepped through</source>
        <translation>Pausar la imagen; se pueden recorrer las últimas</translation>
    </message>
    <message>
        <source>P</source>
        <translation>P</translation>
    </message>
    <message>
        <source>Step &amp;back</source>
        <translation>Imagen a&amp;nterior</translation>
    </message>
    <message>
        <source>Show the previous frame; pauses</source>
        <translation>Mostrar la imagen anterior; pone en pausa</translation>
    </message>
    <message>
        <source>,</source>
        <translation>,</translation>
    </message>
    <message>
        <source>Step f&amp;orward</source>
        <translation>Imagen &amp;siguiente</translation>
    </message>
    <message>
        <source>Show the next frame</source>
        <translation>Mostrar la imagen siguiente</translation>
    </message>
    <message>
        <source>.</source>
        <translation>.</translation>
    </message>
    <message>
        <source>Ctrl+E</source>
        <translation>Ctrl+E</translation>
    </message>
    <message>
        <source>F&amp;ull sensor</source>
        <translation>Sensor completo</translation>
    </message>
    <message>
        <source>Ctrl+Shift+E</source>
        <translation>Ctrl+Shift+E</translation>
    </message>
    <message>
        <source>&amp;Clipping</source>
        <translation>Marcar &amp;saturados</translation>
    </message>
    <message>
        <source>Mark saturated pixels red and black ones blue</source>
        <translation>Marcar en rojo los píxeles saturados y en azul los negros</translation>
    </message>
    <message>
        <source>X</source>
        <translation>X</translation>
    </message>
    <message>
        <source>C&amp;rosshair</source>
        <translation>&amp;Cruz</translation>
    </message>
    <message>
        <source>Mark the middle of the image</source>
        <translation>Marcar el centro de la imagen</translation>
    </message>
    <message>
        <source>C</source>
        <translation>C</translation>
    </message>
    <message>
        <source>&amp;Grid</source>
        <translation>Cuadrícu&amp;la</translation>
    </message>
    <message>
        <source>Divide the image into thirds and more</source>
        <translation>Dividir la imagen en tercios y más</translation>
    </message>
    <message>
        <source>G</source>
        <translation>G</translation>
    </message>
    <message>
        <source>Turn ri&amp;ght</source>
        <translation>Girar a la &amp;derecha</translation>
    </message>
    <message>
        <source>Turn the view clockwise; the frames stay as they are</source>
        <translation>Girar la vista en sentido horario; las imágenes no cambian</translation>
    </message>
    <message>
        <source>R</source>
        <translation>R</translation>
    </message>
    <message>
        <source>Turn &amp;left</source>
        <translation>Girar a la &amp;izquierda</translation>
    </message>
    <message>
        <source>Turn the view anticlockwise</source>
        <translation>Girar la vista en sentido antihorario</translation>
    </message>
    <message>
        <source>Shift+R</source>
        <translation>Shift+R</translation>
    </message>
    <message>
        <source>&amp;Mirror left and right</source>
        <translation>R&amp;eflejar izquierda y derecha</translation>
    </message>
    <message>
        <source>Mirror the view</source>
        <translation>Reflejar la vista</translation>
    </message>
    <message>
        <source>M</source>
        <translation>M</translation>
    </message>
    <message>
        <source>Mirror top and &amp;bottom</source>
        <translation>Reflejar arriba y a&amp;bajo</translation>
    </message>
    <message>
        <source>Shift+M</source>
        <translation>Shift+M</translation>
    </message>
    <message>
        <source>As the &amp;camera sends it</source>
        <translation>Como la envía la &amp;cámara</translation>
    </message>
    <message>
        <source>Neither turned nor mirrored</source>
        <translation>Ni girada ni reflejada</translation>
    </message>
    <message>
        <source>F&amp;ull screen</source>
        <translation>&amp;Pantalla completa</translation>
    </message>
    <message>
        <source>F11</source>
        <translation>F11</translation>
    </message>
    <message>
        <source>&amp;Address…</source>
        <translation>&amp;Dirección…</translation>
    </message>
    <message>
        <source>Type the address of a source</source>
        <translation>Escribir la dirección de una fuente</translation>
    </message>
    <message>
        <source>Ctrl+L</source>
        <translation>Ctrl+L</translation>
    </message>
    <message>
        <source>S&amp;earch again</source>
        <translation>B&amp;uscar de nuevo</translation>
    </message>
    <message>
        <source>&amp;Find a feature</source>
        <translation>&amp;Buscar un parámetro</translation>
    </message>
    <message>
        <source>Filter the camera&apos;s features by name</source>
        <translation>Filtrar los parámetros de la cámara por nombre</translation>
    </message>
    <message>
        <source>Ctrl+F</source>
        <translation>Ctrl+F</translation>
    </message>
    <message>
        <source>&amp;Calibrate camera…</source>
        <translation>&amp;Calibrar la cámara…</translation>
    </message>
    <message>
        <source>Find focal length and distortion with a printed board, for distances and for ROS</source>
        <translation>Hallar distancia focal y distorsión con un tablero impreso, para medir distancias y para ROS</translation>
    </message>
    <message>
        <source>&amp;Keyboard shortcuts</source>
        <translation>&amp;Atajos de teclado</translation>
    </message>
    <message>
        <source>F1</source>
        <translation>F1</translation>
    </message>
    <message>
        <source>&amp;About grabbergui</source>
        <translation>A&amp;cerca de grabbergui</translation>
    </message>
    <message>
        <source>&amp;As the desktop</source>
        <translation>&amp;Como el escritorio</translation>
    </message>
    <message>
        <source>&amp;Light</source>
        <translation>C&amp;laro</translation>
    </message>
    <message>
        <source>&amp;Dark</source>
        <translation>&amp;Oscuro</translation>
    </message>
    <message>
        <source>Grey</source>
        <translation>Gris</translation>
    </message>
    <message>
        <source>Orie&amp;ntation</source>
        <translation>&amp;Orientación</translation>
    </message>
    <message>
        <source>Colours of gre&amp;y images</source>
        <translation>Colores de imágenes en &amp;gris</translation>
    </message>
    <message>
        <source>Open snapshot fold&amp;er</source>
        <translation>&amp;Abrir la carpeta de capturas</translation>
    </message>
    <message>
        <source>Sa&amp;ve settings…</source>
        <translation>&amp;Guardar ajustes…</translation>
    </message>
    <message>
        <source>Re&amp;gion…</source>
        <translation>&amp;Región…</translation>
    </message>
    <message>
        <source>&amp;Expose once</source>
        <translation>&amp;Exponer una vez</translation>
    </message>
    <message>
        <source>Set exposure time and gain by the whole image, once</source>
        <translation>Ajustar una vez la exposición y la ganancia según toda la imagen</translation>
    </message>
    <message>
        <source>E</source>
        <translation>E</translation>
    </message>
    <message>
        <source>Expose on a &amp;region…</source>
        <translation>E&amp;xponer según una región…</translation>
    </message>
    <message>
        <source>Draw the region whose brightness counts; exposure time and gain are set by it, once</source>
        <translation>Dibujar la región cuyo brillo cuenta; la exposición y la ganancia se ajustan una vez según ella</translation>
    </message>
    <message>
        <source>Shift+E</source>
        <translation>Shift+E</translation>
    </message>
    <message>
        <source>&amp;White balance once</source>
        <translation>&amp;Balance de blancos una vez</translation>
    </message>
    <message>
        <source>Set the white balance by the whole image, once</source>
        <translation>Ajustar una vez el balance de blancos según toda la imagen</translation>
    </message>
    <message>
        <source>W</source>
        <translation>W</translation>
    </message>
    <message>
        <source>White &amp;balance on a region…</source>
        <translation>Ba&amp;lance de blancos en una región…</translation>
    </message>
    <message>
        <source>Draw a region that should be grey; the ratios of red and blue are set by it, once</source>
        <translation>Dibujar una región que debería ser gris; las proporciones de rojo y azul se ajustan una vez según ella</translation>
    </message>
    <message>
        <source>Shift+W</source>
        <translation>Shift+W</translation>
    </message>
    <message>
        <source>Compare t&amp;wo files of settings…</source>
        <translation>Comparar dos arc&amp;hivos de ajustes…</translation>
    </message>
    <message>
        <source>Show the differences of two files, and load the values of either</source>
        <translation>Mostrar en qué difieren dos archivos y ajustar la cámara según uno de ellos</translation>
    </message>
    <message>
        <source>Settings &amp;kept in the camera…</source>
        <translation>Ajustes en la cá&amp;mara…</translation>
    </message>
    <message>
        <source>Load and save the sets that the camera keeps itself, and choose which one it starts with</source>
        <translation>Cargar y guardar los juegos que conserva la propia cámara y elegir con cuál arranca</translation>
    </message>
    <message>
        <source>Ctrl+U</source>
        <translation>Ctrl+U</translation>
    </message>
    <message>
        <source>Draw the part of the sensor that the camera sends; this pauses the stream for a moment</source>
        <translation>Dibujar la parte del sensor que la cámara debe enviar; esto detiene la captura un momento</translation>
    </message>
    <message>
        <source>Let the camera send the whole sensor again; this pauses the stream for a moment</source>
        <translation>Que la cámara vuelva a enviar todo el sensor; esto detiene la captura un momento</translation>
    </message>
    <message>
        <source>&amp;Load calibration…</source>
        <translation>Car&amp;gar calibración…</translation>
    </message>
    <message>
        <source>Read a camera_info file, and show the image without the distortion it describes</source>
        <translation>Leer un archivo camera_info y mostrar la imagen sin la distorsión que describe</translation>
    </message>
    <message>
        <source>&amp;Show calibration</source>
        <translation>&amp;Mostrar calibración</translation>
    </message>
    <message>
        <source>Show the image without the lens&apos;s distortion; the camera and saved frames do not change</source>
        <translation>Mostrar la imagen sin la distorsión del objetivo; no cambian ni la cámara ni lo que se guarda</translation>
    </message>
    <message>
        <source>&amp;Manual</source>
        <translation>&amp;Manual</translation>
    </message>
    <message>
        <source>Open the manual</source>
        <translation>Leer el manual</translation>
    </message>
    <message>
        <source>&amp;What&apos;s this?</source>
        <translation>¿&amp;Qué es esto?</translation>
    </message>
    <message>
        <source>Click on anything to read what it does</source>
        <translation>Pulsar sobre cualquier cosa para leer lo que hace</translation>
    </message>
    <message>
        <source>Shift+F1</source>
        <translation>Shift+F1</translation>
    </message>
    <message>
        <source>&amp;Doctor…</source>
        <translation>&amp;Diagnóstico…</translation>
    </message>
    <message>
        <source>Check this computer for the usual problems with cameras</source>
        <translation>Revisar en este equipo lo que suele fallar con las cámaras</translation>
    </message>
    <message>
        <source>Connect to the chosen source without starting it, to set format and region first</source>
        <translation>Conectar con la fuente elegida y fijar formato y región antes de la primera imagen</translation>
    </message>
    <message>
        <source>Connect wit&amp;hout starting</source>
        <translation>Conectar sin inici&amp;ar</translation>
    </message>
    <message>
        <source>&amp;Polarised mosaic</source>
        <translation>&amp;Mosaico polarizado</translation>
    </message>
    <message>
        <source>As sent</source>
        <translation>Como se envía</translation>
    </message>
    <message>
        <source>Intensity</source>
        <translation>Intensidad</translation>
    </message>
    <message>
        <source>Degree of polarisation</source>
        <translation>Grado de polarización</translation>
    </message>
    <message>
        <source>Angle of polarisation</source>
        <translation>Ángulo de polarización</translation>
    </message>
    <message>
        <source>Save the newest frame at full resolution, each of its components: PNG, or TIFF for more than 8 bits</source>
        <translation>Guarda el último fotograma a resolución completa, cada uno de sus componentes: PNG, o TIFF con más de 8 bits</translation>
    </message>
    <message>
        <source>Save point &amp;cloud</source>
        <translation>Guardar nube de p&amp;untos</translation>
    </message>
    <message>
        <source>Save the points of the newest frame&apos;s range image as PLY, in millimetres</source>
        <translation>Guarda los puntos de la imagen de distancias del último fotograma en PLY, en milímetros</translation>
    </message>
    <message>
        <source>Point clou&amp;d…</source>
        <translation>N&amp;ube de puntos…</translation>
    </message>
    <message>
        <source>Show the points of the range image in a window, to turn with the mouse</source>
        <translation>Muestra en una ventana los puntos de la imagen de distancias, que se giran con el ratón</translation>
    </message>
    <message>
        <source>&amp;Sensor has polarisers</source>
        <translation>El &amp;sensor tiene polarizadores</translation>
    </message>
    <message>
        <source>Ticked automatically if the camera's features say so. Sony's arrangement of 90°, 45° over 135°, 0° is assumed.</source>
        <translation>Se marca solo cuando las características de la cámara lo indican. Se supone la disposición de Sony: 90°, 45° sobre 135°, 0°.</translation>
    </message>
    <message>
        <source>Loo&amp;k-up table…</source>
        <translation>&amp;Tabla de consulta…</translation>
    </message>
    <message>
        <source>Show the camera&apos;s look-up table as a curve, edit it, and write it to the camera</source>
        <translation>Muestra la tabla de consulta de la cámara como una curva, para editarla y escribirla en la cámara</translation>
    </message>
    <message>
        <source>Close this panel; to open it again: {0}</source>
        <translation>Cerrar este panel; para volver a abrirlo: {0}</translation>
    </message>
    <message>
        <source>&amp;Report this camera…</source>
        <translation>&amp;Informe de esta cámara…</translation>
    </message>
    <message>
        <source>Write all about the camera to one file, to attach to a bug report</source>
        <translation>Escribir todo sobre la cámara en un archivo, para adjuntarlo a un informe de error</translation>
    </message>
    <message>
        <source>Snapshot for&amp;mat</source>
        <translation>For&amp;mato de captura</translation>
    </message>
    <message>
        <source>Cameras &amp;side by side</source>
        <translation>Cámaras &amp;juntas</translation>
    </message>
    <message>
        <source>Expose</source>
        <translation>Exponer</translation>
    </message>
    <message>
        <source>White balance</source>
        <translation>Balance de blancos</translation>
    </message>
    <message>
        <source>Show the image alone; exposure and gain appear when the mouse moves, Esc returns</source>
        <translation>Mostrar solo la imagen; la exposición y la ganancia aparecen al mover el ratón, Esc vuelve</translation>
    </message>
    <message>
        <source>Cop&amp;y what is shown</source>
        <translation>Cop&amp;iar lo que se ve</translation>
    </message>
    <message>
        <source>Copy the visible part of the image, as it is on the screen, to the clipboard</source>
        <translation>Copiar al portapapeles la parte visible de la imagen, tal como está en la pantalla</translation>
    </message>
    <message>
        <source>Ctrl+Shift+C</source>
        <translation>Ctrl+Shift+C</translation>
    </message>
    <message>
        <source>Reset &amp;layout</source>
        <translation>Restablecer disposició&amp;n</translation>
    </message>
    <message>
        <source>Put all panels back where they were at the first start</source>
        <translation>Devolver todos los paneles al lugar del primer arranque</translation>
    </message>
    <message>
        <source>Sha&amp;re…</source>
        <translation>Compar&amp;tir…</translation>
    </message>
    <message>
        <source>Share the camera on YARP or ROS 2</source>
        <translation>Compartir la cámara en YARP o ROS 2</translation>
    </message>
    <message>
        <source>Frame &amp;data…</source>
        <translation>&amp;Datos del fotograma…</translation>
    </message>
    <message>
        <source>Number, times and chunk data of the shown frame</source>
        <translation>Número, tiempos y datos de chunk del fotograma mostrado</translation>
    </message>
    <message>
        <source>Sa&amp;ve the last frames</source>
        <translation>Guardar los ú&amp;ltimos fotogramas</translation>
    </message>
    <message>
        <source>Save the frames that Pause steps through, in a folder of their own</source>
        <translation>Guardar los fotogramas que recorre Pausa, en una carpeta propia</translation>
    </message>
    <message>
        <source>&amp;{0}</source>
        <translation>&amp;{0}</translation>
    </message>
    <message>
        <source>Frames to record</source>
        <translation>Imágenes que grabar</translation>
    </message>
    <message>
        <source>Events that the camera reports, such as edges on its lines and missed triggers</source>
        <translation>Eventos que comunica la cámara, como flancos en sus líneas y disparos perdidos</translation>
    </message>
    <message>
        <source>New ri&amp;g…</source>
        <translation>&amp;Nuevo grupo de cámaras…</translation>
    </message>
    <message>
        <source>Make one source of several cameras, whose frames come in sets</source>
        <translation>Hacer de varias cámaras una fuente cuyas imágenes llegan en conjuntos</translation>
    </message>
    <message>
        <source>R&amp;ig…</source>
        <translation>G&amp;rupo de cámaras…</translation>
    </message>
    <message>
        <source>Sets of the rig, their skew, the clocks of its cameras and the budget of its link</source>
        <translation>Conjuntos del grupo, su desfase, los relojes de sus cámaras y el presupuesto de su enlace</translation>
    </message>
    <message>
        <source>Separate &amp;zoom</source>
        <translation>&amp;Zoom separado</translation>
    </message>
    <message>
        <source>Zoom and move each camera by itself, not all alike</source>
        <translation>Ampliar y mover cada cámara por separado, no todas a la vez</translation>
    </message>
    <message>
        <source>Ne&amp;xt open source</source>
        <translation>Siguiente &amp;fuente abierta</translation>
    </message>
    <message>
        <source>Eve&amp;nts…</source>
        <translation>E&amp;ventos…</translation>
    </message>
    <message>
        <source>Files &amp;of the camera…</source>
        <translation>E&amp;xplorar los archivos de la cámara…</translation>
    </message>
    <message>
        <source>Download, upload and delete files in the camera</source>
        <translation>Descargar, subir y eliminar archivos de la cámara</translation>
    </message>
</context>
<context>
    <name>ManualDialog</name>
    <message>
        <source>Manual</source>
        <translation>Manual</translation>
    </message>
    <message>
        <source>&amp;Back</source>
        <translation>&amp;Atrás</translation>
    </message>
    <message>
        <source>Close</source>
        <translation>Cerrar</translation>
    </message>
</context>
<context>
    <name>MeasuringController</name>
    <message>
        <source>of {0} × {1} pixels at ({2}, {3})</source>
        <translation>de {0} × {1} píxeles en ({2}, {3})</translation>
    </message>
    <message>
        <source>{0:.2%} saturated · {1:.2%} black</source>
        <translation>{0:.2%} saturado · {1:.2%} negro</translation>
    </message>
</context>
<context>
    <name>MessageBar</name>
    <message>
        <source>Dismiss</source>
        <translation>Descartar</translation>
    </message>
    <message>
        <source>Dismiss this message</source>
        <translation>Descartar este mensaje</translation>
    </message>
</context>
<context>
    <name>MessageLine</name>
    <message>
        <source>Show the messages in full</source>
        <translation>Mostrar los mensajes completos</translation>
    </message>
    <message>
        <source>Dismiss</source>
        <translation>Descartar</translation>
    </message>
    <message>
        <source>Dismiss this message</source>
        <translation>Descartar este mensaje</translation>
    </message>
    <message>
        <source>{0} more</source>
        <translation>{0} más</translation>
    </message>
</context>
<context>
    <name>Messages</name>
    <message>
        <source>{0} could not be written: {1}</source>
        <translation>no se pudo escribir {0}: {1}</translation>
    </message>
</context>
<context>
    <name>NewRigController</name>
    <message>
        <source>File of the rig</source>
        <translation>Archivo del grupo</translation>
    </message>
    <message>
        <source>Rigs (*.yaml)</source>
        <translation>Grupos (*.yaml)</translation>
    </message>
</context>
<context>
    <name>NewRigDialog</name>
    <message>
        <source>New rig</source>
        <translation>Nuevo grupo de cámaras</translation>
    </message>
    <message>
        <source>A rig is several cameras as one source: one trigger, one recording, frames in sets. Tick its cameras, and name them by a double click.</source>
        <translation>Un grupo son varias cámaras como una fuente: un disparo, una grabación, imágenes en conjuntos. Marque sus cámaras y nómbrelas con doble clic.</translation>
    </message>
    <message>
        <source>Cameras of the rig</source>
        <translation>Cámaras del grupo</translation>
    </message>
    <message>
        <source>Name</source>
        <translation>Nombre</translation>
    </message>
    <message>
        <source>Source</source>
        <translation>Fuente</translation>
    </message>
    <message>
        <source>Address of another camera</source>
        <translation>Dirección de otra cámara</translation>
    </message>
    <message>
        <source>Another camera, such as gige:192.168.0.11</source>
        <translation>Otra cámara, como gige:192.168.0.11</translation>
    </message>
    <message>
        <source>&amp;Add</source>
        <translation>&amp;Añadir</translation>
    </message>
    <message>
        <source>&amp;Trigger</source>
        <translation>&amp;Disparo</translation>
    </message>
    <message>
        <source>None: the cameras run freely</source>
        <translation>Ninguno: las cámaras corren libres</translation>
    </message>
    <message>
        <source>Software: a command to each camera</source>
        <translation>Software: una orden a cada cámara</translation>
    </message>
    <message>
        <source>Action: one message to all (GigE Vision)</source>
        <translation>Acción: un mensaje a todas (GigE Vision)</translation>
    </message>
    <message>
        <source>Line: a camera or a signal triggers the others</source>
        <translation>Línea: una cámara o una señal dispara las demás</translation>
    </message>
    <message>
        <source>&amp;Rate</source>
        <translation>&amp;Frecuencia</translation>
    </message>
    <message>
        <source>Triggers per second; at 0 each is sent by hand</source>
        <translation>Disparos por segundo; con 0 se envía cada uno a mano</translation>
    </message>
    <message>
        <source>&amp;Leader</source>
        <translation>&amp;Líder</translation>
    </message>
    <message>
        <source>The camera whose output Line2 triggers the others at Line1</source>
        <translation>La cámara cuya salida Line2 dispara las demás en Line1</translation>
    </message>
    <message>
        <source>&amp;Save and open…</source>
        <translation>&amp;Guardar y abrir…</translation>
    </message>
    <message>
        <source>Cancel</source>
        <translation>Cancelar</translation>
    </message>
    <message>
        <source>two cameras have one name; name each by a double click</source>
        <translation>dos cámaras tienen el mismo nombre; nombre cada una con doble clic</translation>
    </message>
    <message>
        <source>None: a signal from elsewhere</source>
        <translation>Ninguno: una señal externa</translation>
    </message>
</context>
<context>
    <name>NumberField</name>
    <message>
        <source>“{0}” is not a number</source>
        <translation>«{0}» no es un número</translation>
    </message>
    <message>
        <source>“{0}” is not a number in {1}</source>
        <translation>«{0}» no es un número en {1}</translation>
    </message>
</context>
<context>
    <name>PauseBar</name>
    <message>
        <source>Frame that is shown</source>
        <translation>Imagen mostrada</translation>
    </message>
    <message>
        <source>Step through the last frames (, and .)</source>
        <translation>Recorrer las últimas imágenes (, y .)</translation>
    </message>
    <message>
        <source>Frame to show</source>
        <translation>Imagen que mostrar</translation>
    </message>
    <message>
        <source>Show the live image again (P)</source>
        <translation>Volver a la imagen en directo (P)</translation>
    </message>
    <message>
        <source>Live</source>
        <translation>En directo</translation>
    </message>
    <message>
        <source>{0} of {1}   −{2:.2f} s</source>
        <translation>{0} de {1}   −{2:.2f} s</translation>
    </message>
</context>
<context>
    <name>PauseController</name>
    <message>
        <source>there is no frame yet to pause at; start the camera first</source>
        <translation>todavía no hay imagen en la que pausar; inicie antes la cámara</translation>
    </message>
</context>
<context>
    <name>PlaybackBar</name>
    <message>
        <source>Playback</source>
        <translation>Reproducción</translation>
    </message>
    <message>
        <source>Back</source>
        <translation>Atrás</translation>
    </message>
    <message>
        <source>One frame back (,)</source>
        <translation>Una imagen atrás (,)</translation>
    </message>
    <message>
        <source>One frame back</source>
        <translation>Una imagen atrás</translation>
    </message>
    <message>
        <source>Play</source>
        <translation>Reproducir</translation>
    </message>
    <message>
        <source>Play or pause (P)</source>
        <translation>Reproducir o pausar (P)</translation>
    </message>
    <message>
        <source>Forward</source>
        <translation>Adelante</translation>
    </message>
    <message>
        <source>One frame forward (.)</source>
        <translation>Una imagen adelante (.)</translation>
    </message>
    <message>
        <source>One frame forward</source>
        <translation>Una imagen adelante</translation>
    </message>
    <message>
        <source>Where the recording plays</source>
        <translation>Por dónde va la grabación</translation>
    </message>
    <message>
        <source>Position in the recording</source>
        <translation>Posición en la grabación</translation>
    </message>
    <message>
        <source>Time and frame in the recording</source>
        <translation>Tiempo e imagen en la grabación</translation>
    </message>
    <message>
        <source>Speed of playback; 1 is that of the recording</source>
        <translation>A qué velocidad se reproduce; 1 es la velocidad a la que se grabó</translation>
    </message>
    <message>
        <source>Speed</source>
        <translation>Velocidad</translation>
    </message>
    <message>
        <source>Loop</source>
        <translation>Bucle</translation>
    </message>
    <message>
        <source>Begin again at the end</source>
        <translation>Volver a empezar al final</translation>
    </message>
    <message>
        <source>Pause</source>
        <translation>Pausa</translation>
    </message>
</context>
<context>
    <name>PointCloudDialog</name>
    <message>
        <source>Point cloud</source>
        <translation>Nube de puntos</translation>
    </message>
</context>
<context>
    <name>PointCloudView</name>
    <message>
        <source>Point cloud</source>
        <translation>Nube de puntos</translation>
    </message>
    <message>
        <source>Drag to turn, wheel to zoom</source>
        <translation>Arrastre para girar; la rueda amplía</translation>
    </message>
</context>
<context>
    <name>ProfilePanel</name>
    <message>
        <source>Line</source>
        <translation>Línea</translation>
    </message>
    <message>
        <source>Draw the line whose values are shown</source>
        <translation>Dibujar la línea cuyos valores se muestran</translation>
    </message>
    <message>
        <source>Draw line</source>
        <translation>Dibujar línea</translation>
    </message>
    <message>
        <source>Values along the line</source>
        <translation>Valores a lo largo de la línea</translation>
    </message>
    <message>
        <source>The sensor&apos;s values over the pixels along the line</source>
        <translation>Los valores del sensor en los píxeles de la línea</translation>
    </message>
    <message>
        <source>Draw a line through the image to see its values.</source>
        <translation>Dibuje una línea en la imagen para ver sus valores.</translation>
    </message>
    <message>
        <source>The sensor’s own values, of a Bayer pattern each under the colour of its filter; or else the colours shown, in 8 bits</source>
        <translation>Los valores propios del sensor, en un patrón Bayer cada uno bajo el color de su filtro; si no, los colores mostrados, en 8 bits</translation>
    </message>
    <message>
        <source>&amp;Raw values</source>
        <translation>Valores en &amp;bruto</translation>
    </message>
</context>
<context>
    <name>Program</name>
    <message>
        <source>Folder for snapshots</source>
        <translation>Carpeta de capturas</translation>
    </message>
    <message>
        <source>About grabbergui</source>
        <translation>Acerca de grabbergui</translation>
    </message>
    <message>
        <source>&lt;h3&gt;grabbergui {0}&lt;/h3&gt;&lt;p&gt;Tune GenICam cameras live, and share them on YARP and ROS 2 networks.&lt;/p&gt;&lt;p&gt;Free software under the GNU General Public License, version 3 or later, with an additional permission to combine it with the GenICam runtime.&lt;/p&gt;</source>
        <translation>&lt;h3&gt;grabbergui {0}&lt;/h3&gt;&lt;p&gt;Ajusta cámaras GenICam en directo y las comparte en redes YARP y ROS 2.&lt;/p&gt;&lt;p&gt;Software libre bajo la Licencia Pública General de GNU, versión 3 o posterior, con un permiso adicional para combinarlo con las bibliotecas de GenICam.&lt;/p&gt;</translation>
    </message>
    <message>
        <source>{0} could not be opened: {1}</source>
        <translation>{0} no se pudo abrir: {1}</translation>
    </message>
    <message>
        <source>Snapshots are in {0}; no file manager could be started</source>
        <translation>Las capturas están en {0}; no se pudo abrir un gestor de archivos</translation>
    </message>
    <message>
        <source>{0} cannot be written: the window will forget its arrangement and your choices</source>
        <translation>No se puede escribir {0}: la ventana olvidará su disposición y sus elecciones</translation>
    </message>
</context>
<context>
    <name>Recording</name>
    <message>
        <source>internal error, see the log: {0}</source>
        <translation>error interno, véase el registro: {0}</translation>
    </message>
    <message>
        <source>the source was closed</source>
        <translation>se cerró la fuente</translation>
    </message>
    <message>
        <source>the disk of {0} is full ({1} MiB left)</source>
        <translation>el disco de {0} está lleno (quedan {1} MiB)</translation>
    </message>
    <message>
        <source>; {0} frames recorded by then are kept</source>
        <translation>; se conservan las {0} imágenes grabadas hasta entonces</translation>
    </message>
    <message>
        <source>; 1 frame recorded by then is kept</source>
        <translation>; se conserva 1 imagen grabada hasta entonces</translation>
    </message>
    <message>
        <source>; nothing was recorded</source>
        <translation>; no se grabó nada</translation>
    </message>
    <message>
        <source>{0} could not be finished: {1}</source>
        <translation>no se pudo terminar {0}: {1}</translation>
    </message>
    <message>
        <source>the recording of {0} ended: {1}</source>
        <translation>la grabación de {0} terminó: {1}</translation>
    </message>
    <message>
        <source>nothing was recorded of {0}</source>
        <translation>no se grabó nada de {0}</translation>
    </message>
    <message>
        <source>1 frame</source>
        <translation>1 imagen</translation>
    </message>
    <message>
        <source>{0} frames</source>
        <translation>{0} imágenes</translation>
    </message>
    <message>
        <source>recorded {0} to {1}</source>
        <translation>grabación de {0} en {1}</translation>
    </message>
</context>
<context>
    <name>RecordingBar</name>
    <message>
        <source>Record</source>
        <translation>Grabar</translation>
    </message>
    <message>
        <source>Record every frame from now on; press again to stop</source>
        <translation>Grabar cada imagen desde ahora; pulse otra vez para parar</translation>
    </message>
    <message>
        <source>File format of the recording</source>
        <translation>Formato de la grabación</translation>
    </message>
    <message>
        <source>Kind of recording</source>
        <translation>Tipo de grabación</translation>
    </message>
    <message>
        <source>When the recording ends automatically</source>
        <translation>Cuándo acaba sola la grabación</translation>
    </message>
    <message>
        <source>End of the recording</source>
        <translation>Final de la grabación</translation>
    </message>
    <message>
        <source>Until stopped</source>
        <translation>Hasta pararla</translation>
    </message>
    <message>
        <source>For a time</source>
        <translation>Durante un tiempo</translation>
    </message>
    <message>
        <source>For a number of frames</source>
        <translation>Un número de imágenes</translation>
    </message>
    <message>
        <source>Up to a size</source>
        <translation>Hasta un tamaño</translation>
    </message>
    <message>
        <source>Limit of the recording</source>
        <translation>Límite de la grabación</translation>
    </message>
    <message>
        <source>Length of the recording</source>
        <translation>Duración de la grabación</translation>
    </message>
    <message>
        <source>Folder</source>
        <translation>Carpeta</translation>
    </message>
    <message>
        <source>Choose where recordings go</source>
        <translation>Elegir dónde se guardan las grabaciones</translation>
    </message>
    <message>
        <source>Folder of recordings</source>
        <translation>Carpeta de grabaciones</translation>
    </message>
    <message>
        <source>Play</source>
        <translation>Reproducir</translation>
    </message>
    <message>
        <source>Play the last recording in place of the camera</source>
        <translation>Reproducir la última grabación en lugar de la cámara</translation>
    </message>
    <message>
        <source>Play the last recording</source>
        <translation>Reproducir la última grabación</translation>
    </message>
    <message>
        <source>Movie (MP4)</source>
        <translation>Vídeo (MP4)</translation>
    </message>
    <message>
        <source>Movie, lossless (MP4)</source>
        <translation>Vídeo sin pérdidas (MP4)</translation>
    </message>
    <message>
        <source>Images (PNG)</source>
        <translation>Imágenes (PNG)</translation>
    </message>
    <message>
        <source>Images (TIFF, fast)</source>
        <translation>Imágenes (TIFF, rápido)</translation>
    </message>
    <message>
        <source>Stop recording</source>
        <translation>Dejar de grabar</translation>
    </message>
    <message>
        <source>{0} frames</source>
        <translation>{0} imágenes</translation>
    </message>
    <message>
        <source>{0} dropped</source>
        <translation>{0} descartadas</translation>
    </message>
    <message>
        <source>{0} free</source>
        <translation>{0} libres</translation>
    </message>
    <message>
        <source>Play {0} in place of the camera</source>
        <translation>Reproducir {0} en lugar de la cámara</translation>
    </message>
    <message>
        <source>Movie, lossless up to 16 bits (FFV1)</source>
        <translation>Vídeo sin pérdidas de hasta 16 bits (FFV1)</translation>
    </message>
    <message>
        <source>1 frame</source>
        <translation>1 imagen</translation>
    </message>
    <message>
        <source>first image of {0}</source>
        <translation>primera imagen de {0}</translation>
    </message>
    <message>
        <source>1 dropped</source>
        <translation>1 descartada</translation>
    </message>
    <message>
        <source>One TIFF with pages</source>
        <translation>Un TIFF con páginas</translation>
    </message>
    <message>
        <source>NumPy array (.npy)</source>
        <translation>Matriz de NumPy (.npy)</translation>
    </message>
    <message>
        <source>for {0}</source>
        <translation>para {0}</translation>
    </message>
    <message>
        <source>All raw data (MCAP)</source>
        <translation>Todos los datos en bruto (MCAP)</translation>
    </message>
    <message>
        <source>All raw data (ROS 2 bag)</source>
        <translation>Todos los datos en bruto (bag de ROS 2)</translation>
    </message>
</context>
<context>
    <name>RecordingController</name>
    <message>
        <source>Folder for recordings</source>
        <translation>Carpeta para grabaciones</translation>
    </message>
    <message>
        <source>Recording</source>
        <translation>Grabación</translation>
    </message>
    <message>
        <source>Closing ends the recording; what was recorded so far is kept.</source>
        <translation>Al cerrar termina la grabación; lo grabado hasta ahora se conserva.</translation>
    </message>
    <message>
        <source>Stop recording and close</source>
        <translation>Detener la grabación y cerrar</translation>
    </message>
    <message>
        <source>Continue recording</source>
        <translation>Seguir grabando</translation>
    </message>
    <message>
        <source>Being recorded: {0}</source>
        <translation>Se está grabando: {0}</translation>
    </message>
</context>
<context>
    <name>RegionController</name>
    <message>
        <source>the region could not be changed: {0}</source>
        <translation>no se pudo cambiar la región: {0}</translation>
    </message>
    <message>
        <source>Region of the sensor</source>
        <translation>Región del sensor</translation>
    </message>
    <message>
        <source>there is no image yet to draw on; start the camera first, or write OffsetX, OffsetY, Width and Height</source>
        <translation>todavía no hay imagen sobre la que dibujar; inicie primero la cámara, o escriba OffsetX, OffsetY, Width y Height</translation>
    </message>
</context>
<context>
    <name>Remote</name>
    <message>
        <source>{0} from {1}</source>
        <translation>{0} desde {1}</translation>
    </message>
    <message>
        <source>A remote camera: {0} over {1}.</source>
        <translation>Una cámara remota: {0} por {1}.</translation>
    </message>
    <message>
        <source>under {0} s old</source>
        <translation>hace menos de {0} s</translation>
    </message>
    <message>
        <source>{0} s old</source>
        <translation>hace {0} s</translation>
    </message>
    <message>
        <source>The shown image is {0}.</source>
        <translation>Imagen mostrada: {0}.</translation>
    </message>
</context>
<context>
    <name>ReportController</name>
    <message>
        <source>Save the report</source>
        <translation>Guardar el informe</translation>
    </message>
    <message>
        <source>Reports (*.zip)</source>
        <translation>Informes (*.zip)</translation>
    </message>
    <message>
        <source>{0} cannot be written: {1}</source>
        <translation>No se puede escribir {0}: {1}</translation>
    </message>
    <message>
        <source>Saved the report to {0}</source>
        <translation>Informe guardado en {0}</translation>
    </message>
</context>
<context>
    <name>ReportDialog</name>
    <message>
        <source>Report this camera</source>
        <translation>Informe de esta cámara</translation>
    </message>
    <message>
        <source>Asking the camera and this computer…</source>
        <translation>Consultando la cámara y este ordenador…</translation>
    </message>
    <message>
        <source>Contents of the report</source>
        <translation>Contenido del informe</translation>
    </message>
    <message>
        <source>Keep &amp;names, serial numbers and addresses</source>
        <translation>Conservar &amp;nombres, números de serie y direcciones</translation>
    </message>
    <message>
        <source>Otherwise stand-ins replace them, also in registers and log</source>
        <translation>Si no, se sustituyen por otros, también en registros y en el log</translation>
    </message>
    <message>
        <source>With the &amp;pixels of some frames</source>
        <translation>Con los &amp;píxeles de algunos fotogramas</translation>
    </message>
    <message>
        <source>The file will contain:</source>
        <translation>El archivo contendrá:</translation>
    </message>
</context>
<context>
    <name>Rig</name>
    <message>
        <source>grandmaster {0}</source>
        <translation>reloj maestro {0}</translation>
    </message>
    <message>
        <source>{0} µs from its master</source>
        <translation>a {0} µs de su maestro</translation>
    </message>
    <message>
        <source>fitted to the host&apos;s</source>
        <translation>ajustado al del ordenador</translation>
    </message>
    <message>
        <source>times of arrival</source>
        <translation>momentos de llegada</translation>
    </message>
</context>
<context>
    <name>RigController</name>
    <message>
        <source>Written to the cameras and into {0}.</source>
        <translation>Escrito en las cámaras y en {0}.</translation>
    </message>
    <message>
        <source>{0} has no such values any more; the cameras keep theirs.</source>
        <translation>{0} ya no tiene esos valores; las cámaras conservan los suyos.</translation>
    </message>
</context>
<context>
    <name>RigDialog</name>
    <message>
        <source>Rig</source>
        <translation>Grupo de cámaras</translation>
    </message>
    <message>
        <source>Sets of frames</source>
        <translation>Conjuntos de imágenes</translation>
    </message>
    <message>
        <source>Skew of the sets</source>
        <translation>Desfase de los conjuntos</translation>
    </message>
    <message>
        <source>Skew of the recent sets</source>
        <translation>Desfase de los conjuntos recientes</translation>
    </message>
    <message>
        <source>Cameras of the rig</source>
        <translation>Cámaras del grupo</translation>
    </message>
    <message>
        <source>Camera</source>
        <translation>Cámara</translation>
    </message>
    <message>
        <source>Frames</source>
        <translation>Imágenes</translation>
    </message>
    <message>
        <source>Missing in sets</source>
        <translation>Faltan en conjuntos</translation>
    </message>
    <message>
        <source>Clock</source>
        <translation>Reloj</translation>
    </message>
    <message>
        <source>Budget of the link</source>
        <translation>Presupuesto del enlace</translation>
    </message>
    <message>
        <source>&amp;Compute again</source>
        <translation>&amp;Calcular de nuevo</translation>
    </message>
    <message>
        <source>&amp;Apply</source>
        <translation>&amp;Aplicar</translation>
    </message>
    <message>
        <source>Write the values of the column “Set” to the cameras and into the rig's file; Undo takes them back</source>
        <translation>Escribir los valores de la columna «Ajuste» en las cámaras y en el archivo del grupo; Deshacer los retira</translation>
    </message>
    <message>
        <source>&amp;Remove from the file</source>
        <translation>&amp;Quitar del archivo</translation>
    </message>
    <message>
        <source>Take these values out of the rig&apos;s file; the cameras keep theirs</source>
        <translation>Quitar estos valores del archivo del grupo; las cámaras conservan los suyos</translation>
    </message>
    <message>
        <source>Close</source>
        <translation>Cerrar</translation>
    </message>
    <message>
        <source>Rig {0}</source>
        <translation>Grupo {0}</translation>
    </message>
    <message>
        <source>Skew {0:.1f} µs (median) · {1:.1f} µs (p99) · {2:.1f} µs (worst)</source>
        <translation>Desfase {0:.1f} µs (mediana) · {1:.1f} µs (p99) · {2:.1f} µs (peor)</translation>
    </message>
    <message>
        <source>These cameras are on no link that they share.</source>
        <translation>Estas cámaras no comparten ningún enlace.</translation>
    </message>
    <message>
        <source>All frames fit into the link.</source>
        <translation>Todas las imágenes caben en el enlace.</translation>
    </message>
    <message>
        <source>Frame</source>
        <translation>Imagen</translation>
    </message>
    <message>
        <source>Rate</source>
        <translation>Frecuencia</translation>
    </message>
    <message>
        <source>Packet</source>
        <translation>Paquete</translation>
    </message>
    <message>
        <source>Needs</source>
        <translation>Necesita</translation>
    </message>
    <message>
        <source>Share</source>
        <translation>Compartir</translation>
    </message>
    <message>
        <source>Frame takes</source>
        <translation>Dura</translation>
    </message>
    <message>
        <source>Set</source>
        <translation>Ajuste</translation>
    </message>
    <message>
        <source>sets before the newest</source>
        <translation>conjuntos antes del último</translation>
    </message>
    <message>
        <source>µs</source>
        <translation>µs</translation>
    </message>
    <message>
        <source>Complete sets: {0} · late: {1} · incomplete: {2}</source>
        <translation>Conjuntos completos: {0} · tardíos: {1} · incompletos: {2}</translation>
    </message>
    <message>
        <source>Cameras</source>
        <translation>Cámaras</translation>
    </message>
    <message>
        <source>Events</source>
        <translation>Eventos</translation>
    </message>
    <message>
        <source>Events of the cameras, the newest first</source>
        <translation>Eventos de las cámaras, el más reciente primero</translation>
    </message>
    <message>
        <source>Time</source>
        <translation>Hora</translation>
    </message>
    <message>
        <source>Event</source>
        <translation>Evento</translation>
    </message>
    <message>
        <source>Values</source>
        <translation>Valores</translation>
    </message>
    <message>
        <source>The others &amp;follow</source>
        <translation>Las otras s&amp;iguen</translation>
    </message>
    <message>
        <source>Copy exposure time, gain and white balance of this camera to the others, as long as the rig is open; its file stays as it is</source>
        <translation>Copiar tiempo de exposición, ganancia y balance de blancos de esta cámara a las otras mientras el grupo esté abierto; su archivo no cambia</translation>
    </message>
    <message>
        <source>none: each has its own settings</source>
        <translation>ninguna: cada una tiene sus propios ajustes</translation>
    </message>
</context>
<context>
    <name>RobotView</name>
    <message>
        <source>Drag to rotate, wheel to zoom, double-click to reset</source>
        <translation>Arrastrar para girar, rueda para acercarse, doble clic para volver</translation>
    </message>
    <message>
        <source>The robot has not answered yet</source>
        <translation>El robot todavía no ha respondido</translation>
    </message>
</context>
<context>
    <name>ScaleBar</name>
    <message>
        <source>Scale of the colours: {0}</source>
        <translation>Escala de los colores: {0}</translation>
    </message>
    <message>
        <source>no data</source>
        <translation>sin datos</translation>
    </message>
</context>
<context>
    <name>Section</name>
    <message>
        <source>Expand all</source>
        <translation>Expandir todo</translation>
    </message>
    <message>
        <source>Collapse all</source>
        <translation>Contraer todo</translation>
    </message>
</context>
<context>
    <name>ServoController</name>
    <message>
        <source>The camera is not calibrated, a field of view is assumed: distances are rough</source>
        <translation>La cámara no está calibrada, se supone un campo de visión: las distancias son aproximadas</translation>
    </message>
    <message>
        <source>Calibrate…</source>
        <translation>Calibrar…</translation>
    </message>
    <message>
        <source>{0} is in use; Start lets the robot move</source>
        <translation>{0} está en uso; Iniciar permite que el robot se mueva</translation>
    </message>
</context>
<context>
    <name>ServoWindow</name>
    <message>
        <source>Visual servoing</source>
        <translation>Control visual</translation>
    </message>
    <message>
        <source>The states of the loop; the current one is lit</source>
        <translation>Los estados del bucle; el actual está iluminado</translation>
    </message>
    <message>
        <source>S&amp;tart</source>
        <translation>&amp;Iniciar</translation>
    </message>
    <message>
        <source>EMERGENCY STOP</source>
        <translation>PARADA DE EMERGENCIA</translation>
    </message>
    <message>
        <source>Stops the robot at once (Space, Escape)</source>
        <translation>Para el robot de inmediato (Espacio, Escape)</translation>
    </message>
    <message>
        <source>History of states</source>
        <translation>Historial de estados</translation>
    </message>
    <message>
        <source>Time</source>
        <translation>Hora</translation>
    </message>
    <message>
        <source>State</source>
        <translation>Estado</translation>
    </message>
    <message>
        <source>Why</source>
        <translation>Por qué</translation>
    </message>
    <message>
        <source>&amp;Head gain</source>
        <translation>Ganancia de la &amp;cabeza</translation>
    </message>
    <message>
        <source>Speed of the head for each radian off centre</source>
        <translation>Velocidad de la cabeza por cada radián de desviación</translation>
    </message>
    <message>
        <source> /s</source>
        <translation> /s</translation>
    </message>
    <message>
        <source>Head at &amp;most</source>
        <translation>Cabeza como &amp;máximo</translation>
    </message>
    <message>
        <source> °/s</source>
        <translation> °/s</translation>
    </message>
    <message>
        <source>&amp;Arm gain</source>
        <translation>Ganancia del &amp;brazo</translation>
    </message>
    <message>
        <source>Speed of the hand for each metre and radian of error</source>
        <translation>Velocidad de la mano por cada metro y radián de error</translation>
    </message>
    <message>
        <source>Han&amp;d at most</source>
        <translation>Mano como má&amp;ximo</translation>
    </message>
    <message>
        <source> mm/s</source>
        <translation> mm/s</translation>
    </message>
    <message>
        <source>&amp;Rate</source>
        <translation>&amp;Frecuencia</translation>
    </message>
    <message>
        <source>Commands per second</source>
        <translation>Órdenes por segundo</translation>
    </message>
    <message>
        <source> Hz</source>
        <translation> Hz</translation>
    </message>
    <message>
        <source>Live image</source>
        <translation>Imagen en directo</translation>
    </message>
    <message>
        <source>The robot in space</source>
        <translation>El robot en el espacio</translation>
    </message>
    <message>
        <source>Let the robot move</source>
        <translation>Deja que el robot se mueva</translation>
    </message>
    <message>
        <source>Hand to goal, mm</source>
        <translation>Mano a objetivo, mm</translation>
    </message>
    <message>
        <source>Hand to goal, °</source>
        <translation>Mano a objetivo, °</translation>
    </message>
    <message>
        <source>Velocity of the hand, mm/s</source>
        <translation>Velocidad de la mano, mm/s</translation>
    </message>
    <message>
        <source>Rotation of the hand, °/s</source>
        <translation>Giro de la mano, °/s</translation>
    </message>
    <message>
        <source>S&amp;peed</source>
        <translation>&amp;Velocidad</translation>
    </message>
    <message>
        <source>All motion is slowed down to this share of its speed</source>
        <translation>Todo movimiento se frena a esta parte de su velocidad</translation>
    </message>
    <message>
        <source> %</source>
        <translation> %</translation>
    </message>
    <message>
        <source>Hand–&amp;eye…</source>
        <translation>Mano-&amp;ojo…</translation>
    </message>
    <message>
        <source>Calibrate where the camera is mounted: the loop ends, and the robot looks at a board from several poses</source>
        <translation>Calibrar dónde está la cámara: el lazo termina y el robot mira un tablero desde varias posturas</translation>
    </message>
    <message>
        <source>What is measured of the hand, and the limits that it keeps</source>
        <translation>Lo que se mide de la mano y los límites que respeta</translation>
    </message>
</context>
<context>
    <name>Servoing</name>
    <message>
        <source>searching</source>
        <translation>buscando</translation>
    </message>
    <message>
        <source>centring</source>
        <translation>centrando</translation>
    </message>
    <message>
        <source>waiting for the marker</source>
        <translation>esperando el marcador</translation>
    </message>
    <message>
        <source>approaching</source>
        <translation>acercándose</translation>
    </message>
    <message>
        <source>reached</source>
        <translation>alcanzado</translation>
    </message>
    <message>
        <source>stuck</source>
        <translation>atascado</translation>
    </message>
    <message>
        <source>lost</source>
        <translation>perdido</translation>
    </message>
    <message>
        <source>stopped</source>
        <translation>parado</translation>
    </message>
    <message>
        <source>following</source>
        <translation>siguiendo</translation>
    </message>
    <message>
        <source>Hand: {0} of {1} mm/s, {2} of {3} °/s, {4} mm inside its workspace</source>
        <translation>Mano: {0} de {1} mm/s, {2} de {3} °/s, {4} mm dentro de su espacio de trabajo</translation>
    </message>
</context>
<context>
    <name>Settings</name>
    <message>
        <source>the stream does not start again: {0}</source>
        <translation>la captura no vuelve a arrancar: {0}</translation>
    </message>
    <message>
        <source>cancelled</source>
        <translation>cancelado</translation>
    </message>
    <message>
        <source>{0} sets it</source>
        <translation>lo fija {0}</translation>
    </message>
    <message>
        <source>{0} is off in the set; writing this would turn it on</source>
        <translation>{0} está apagado en el archivo; escribir esto lo encendería</translation>
    </message>
    <message>
        <source>it is a command; loading settings runs none</source>
        <translation>es una orden; al cargar ajustes no se ejecuta ninguna</translation>
    </message>
    <message>
        <source>the camera reports {0}</source>
        <translation>la cámara indica {0}</translation>
    </message>
    <message>
        <source>interrupted: {0}</source>
        <translation>interrumpido: {0}</translation>
    </message>
    <message>
        <source>the camera was lost during this write: it may have either value</source>
        <translation>la cámara se perdió durante esta escritura: puede tener cualquiera de los dos valores</translation>
    </message>
</context>
<context>
    <name>SettingsDifference</name>
    <message>
        <source>Compare settings</source>
        <translation>Comparar ajustes</translation>
    </message>
    <message>
        <source>Differences</source>
        <translation>Diferencias</translation>
    </message>
    <message>
        <source>Setting</source>
        <translation>Ajuste</translation>
    </message>
    <message>
        <source>Close</source>
        <translation>Cerrar</translation>
    </message>
    <message>
        <source>There is no difference.</source>
        <translation>No hay ninguna diferencia.</translation>
    </message>
    <message>
        <source>Set as in {0}</source>
        <translation>Ajustar como en {0}</translation>
    </message>
    <message>
        <source>(not in this file)</source>
        <translation>(no está)</translation>
    </message>
    <message>
        <source>1 setting differs. If it is ticked, it can be set on the camera.</source>
        <translation>1 ajuste difiere. Si está marcado, se puede ajustar en la cámara.</translation>
    </message>
    <message>
        <source>{0} settings differ. Those that are ticked can be set on the camera.</source>
        <translation>{0} ajustes difieren. Los marcados se pueden ajustar en la cámara.</translation>
    </message>
</context>
<context>
    <name>SettingsFilesController</name>
    <message>
        <source>Settings (*.yaml *.yml *.pfs *.txt);;All files (*)</source>
        <translation>Ajustes (*.yaml *.yml *.pfs *.txt);;Todos los archivos (*)</translation>
    </message>
    <message>
        <source>Save settings</source>
        <translation>Guardar ajustes</translation>
    </message>
    <message>
        <source>Load settings</source>
        <translation>Cargar ajustes</translation>
    </message>
    <message>
        <source>Compare the camera with settings</source>
        <translation>Comparar la cámara con unos ajustes</translation>
    </message>
    <message>
        <source>Camera and {0}</source>
        <translation>Cámara y {0}</translation>
    </message>
    <message>
        <source>Loaded {0}</source>
        <translation>Cargado {0}</translation>
    </message>
    <message>
        <source>Rolled back: {0}</source>
        <translation>Revertido: {0}</translation>
    </message>
    <message>
        <source>First settings</source>
        <translation>Primeros ajustes</translation>
    </message>
    <message>
        <source>Second settings</source>
        <translation>Segundos ajustes</translation>
    </message>
    <message>
        <source>Saving settings</source>
        <translation>Guardando ajustes</translation>
    </message>
    <message>
        <source>Loading settings</source>
        <translation>Cargando ajustes</translation>
    </message>
    <message>
        <source>Comparing settings</source>
        <translation>Comparando ajustes</translation>
    </message>
    <message>
        <source>Rolling back</source>
        <translation>Revirtiendo</translation>
    </message>
    <message>
        <source>1 setting</source>
        <translation>1 ajuste</translation>
    </message>
    <message>
        <source>{0} settings</source>
        <translation>{0} ajustes</translation>
    </message>
    <message>
        <source>Saved {0} to {1}</source>
        <translation>Guardado: {0} en {1}</translation>
    </message>
    <message>
        <source>Not rolled back: {0}</source>
        <translation>No revertido: {0}</translation>
    </message>
</context>
<context>
    <name>SettingsReport</name>
    <message>
        <source>Settings</source>
        <translation>Ajustes</translation>
    </message>
    <message>
        <source>Setting</source>
        <translation>Ajuste</translation>
    </message>
    <message>
        <source>File</source>
        <translation>Archivo</translation>
    </message>
    <message>
        <source>Why</source>
        <translation>Por qué</translation>
    </message>
    <message>
        <source>Show &amp;equal settings</source>
        <translation>Mostrar lo que era i&amp;gual</translation>
    </message>
    <message>
        <source>&amp;Apply to the camera</source>
        <translation>&amp;Aplicar a la cámara</translation>
    </message>
    <message>
        <source>&amp;Roll back</source>
        <translation>&amp;Revertir</translation>
    </message>
    <message>
        <source>Close</source>
        <translation>Cerrar</translation>
    </message>
    <message>
        <source>written</source>
        <translation>escrito</translation>
    </message>
    <message>
        <source>equal</source>
        <translation>igual</translation>
    </message>
    <message>
        <source>refused</source>
        <translation>rechazado</translation>
    </message>
    <message>
        <source>left alone</source>
        <translation>sin tocar</translation>
    </message>
    <message>
        <source>unknown</source>
        <translation>desconocido</translation>
    </message>
    <message>
        <source>cancelled</source>
        <translation>cancelado</translation>
    </message>
    <message>
        <source>Result</source>
        <translation>Resultado</translation>
    </message>
    <message>
        <source>Nothing to do</source>
        <translation>Nada que hacer</translation>
    </message>
    <message>
        <source>came out different</source>
        <translation>quedó distinto</translation>
    </message>
    <message>
        <source>would be written</source>
        <translation>por escribir</translation>
    </message>
    <message>
        <source>not a setting</source>
        <translation>no es un ajuste</translation>
    </message>
    <message>
        <source>depends on the others</source>
        <translation>depende de los demás</translation>
    </message>
    <message>
        <source>Settings already written are restored when the camera is back, the others are not</source>
        <translation>Lo escrito se vuelve a ajustar cuando la cámara regrese; el resto no</translation>
    </message>
    <message>
        <source>not written</source>
        <translation>no escrito</translation>
    </message>
    <message>
        <source>Before</source>
        <translation>Antes</translation>
    </message>
    <message>
        <source>Now</source>
        <translation>Ahora</translation>
    </message>
</context>
<context>
    <name>ShareDialog</name>
    <message>
        <source>Share the camera</source>
        <translation>Compartir la cámara</translation>
    </message>
    <message>
        <source>Others receive images and values, and cannot change anything</source>
        <translation>Los demás reciben imágenes y valores, y no pueden cambiar nada</translation>
    </message>
    <message>
        <source>Others may only &amp;look</source>
        <translation>Los demás so&amp;lo pueden mirar</translation>
    </message>
    <message>
        <source>&amp;Connected</source>
        <translation>C&amp;onectados</translation>
    </message>
    <message>
        <source>Connected programs</source>
        <translation>Programas conectados</translation>
    </message>
    <message>
        <source>Program</source>
        <translation>Programa</translation>
    </message>
    <message>
        <source>Takes</source>
        <translation>Recibe</translation>
    </message>
    <message>
        <source>From</source>
        <translation>Desde</translation>
    </message>
    <message>
        <source>Port or topic</source>
        <translation>Puerto o tema</translation>
    </message>
    <message>
        <source>C&amp;hanged by others</source>
        <translation>Ca&amp;mbiado por otros</translation>
    </message>
    <message>
        <source>Changes by others</source>
        <translation>Cambios de otros</translation>
    </message>
    <message>
        <source>Close this dialog; the camera stays shared</source>
        <translation>Cerrar este diálogo; la cámara sigue compartida</translation>
    </message>
    <message>
        <source>Close</source>
        <translation>Cerrar</translation>
    </message>
    <message>
        <source>{0}: others see its image and settings while this window is open.</source>
        <translation>{0}: los demás ven su imagen y sus ajustes mientras esta ventana esté abierta.</translation>
    </message>
    <message>
        <source>No camera is open.</source>
        <translation>No hay ninguna cámara abierta.</translation>
    </message>
    <message>
        <source>no images</source>
        <translation>sin imágenes</translation>
    </message>
</context>
<context>
    <name>ShareNetworkBox</name>
    <message>
        <source>Name</source>
        <translation>Nombre</translation>
    </message>
    <message>
        <source>Share</source>
        <translation>Compartir</translation>
    </message>
    <message>
        <source>Name server</source>
        <translation>Servidor de nombres</translation>
    </message>
    <message>
        <source>HOST:PORT of the YARP name server; empty: the one that YARP is configured for</source>
        <translation>EQUIPO:PUERTO del servidor de nombres de YARP; vacío: el que YARP tiene configurado</translation>
    </message>
    <message>
        <source>as YARP is configured</source>
        <translation>según la configuración de YARP</translation>
    </message>
    <message>
        <source>Run a name server in this window: for this computer, or at the address of this computer that you write. It ends with the window</source>
        <translation>Ejecutar un servidor de nombres en esta ventana: para este ordenador, o en la dirección de este ordenador que escriba. Termina con la ventana</translation>
    </message>
    <message>
        <source>Run it here</source>
        <translation>Ejecutarlo aquí</translation>
    </message>
    <message>
        <source>Domain</source>
        <translation>Dominio</translation>
    </message>
    <message>
        <source>Only nodes of the same domain see the camera</source>
        <translation>Solo los nodos del mismo dominio ven la cámara</translation>
    </message>
    <message>
        <source>as ROS_DOMAIN_ID</source>
        <translation>según ROS_DOMAIN_ID</translation>
    </message>
    <message>
        <source>The port&apos;s name</source>
        <translation>Nombre del puerto</translation>
    </message>
    <message>
        <source>The node&apos;s name, which prefixes its topics</source>
        <translation>Nombre del nodo, que precede a sus temas</translation>
    </message>
    <message>
        <source>Stop</source>
        <translation>Detener</translation>
    </message>
    <message>
        <source>Run a name server here</source>
        <translation>Ejecutar aquí un servidor de nombres</translation>
    </message>
    <message>
        <source>Copy the command</source>
        <translation>Copiar la orden</translation>
    </message>
    <message>
        <source>Starting…</source>
        <translation>Iniciando…</translation>
    </message>
    <message>
        <source>Stopping…</source>
        <translation>Deteniendo…</translation>
    </message>
</context>
<context>
    <name>Sharing</name>
    <message>
        <source>{0:.1f} images/s · {1:.1f} MB/s</source>
        <translation>{0:.1f} imágenes/s · {1:.1f} MB/s</translation>
    </message>
    <message>
        <source>no YARP name server answers at {0}</source>
        <translation>ningún servidor de nombres de YARP responde en {0}</translation>
    </message>
    <message>
        <source>ROS 2 is not installed; this command installs it: {0}</source>
        <translation>ROS 2 no está instalado; esta orden lo instala: {0}</translation>
    </message>
</context>
<context>
    <name>SharingController</name>
    <message>
        <source>{0} and {1} more</source>
        <translation>{0} y {1} más</translation>
    </message>
    <message>
        <source>Others read this camera: {0}</source>
        <translation>Otros leen esta cámara: {0}</translation>
    </message>
    <message>
        <source>They receive no more images.</source>
        <translation>Dejarán de recibir imágenes.</translation>
    </message>
    <message>
        <source>Share</source>
        <translation>Compartir</translation>
    </message>
    <message>
        <source>Stop sharing</source>
        <translation>Dejar de compartir</translation>
    </message>
    <message>
        <source>Keep sharing</source>
        <translation>Seguir compartiendo</translation>
    </message>
    <message>
        <source>Share this camera with other programs and computers</source>
        <translation>Compartir esta cámara con otros programas y ordenadores</translation>
    </message>
    <message>
        <source>Shared ({0})</source>
        <translation>Compartida ({0})</translation>
    </message>
    <message>
        <source>Shared on {0}</source>
        <translation>Compartida en {0}</translation>
    </message>
</context>
<context>
    <name>ShortcutsDialog</name>
    <message>
        <source>Keyboard and mouse</source>
        <translation>Teclado y ratón</translation>
    </message>
    <message>
        <source>Close</source>
        <translation>Cerrar</translation>
    </message>
    <message>
        <source>Over the image the wheel zooms, dragging moves it, and a double click fits it or shows it 1:1. A slider takes the wheel, the arrow keys, Page Up and Down, Home and End; with Shift it goes a tenth as far, with Ctrl ten times as far. Esc cancels what is being drawn or typed. Letters work while the image has the focus: Enter gives it back.</source>
        <translation>Sobre la imagen la rueda amplía, arrastrar la mueve y un doble clic la ajusta o la muestra 1:1. Un deslizador acepta la rueda, las flechas, Re Pág y Av Pág, Inicio y Fin; con Mayús avanza una décima parte, con Ctrl diez veces más. Esc abandona lo que se dibuja o escribe. Las letras actúan mientras la imagen tiene el foco: Intro se lo devuelve.</translation>
    </message>
    <message>
        <source>Shift</source>
        <translation>Mayús</translation>
    </message>
</context>
<context>
    <name>SnapshotKindController</name>
    <message>
        <source>PNG, or TIFF above 8 bits</source>
        <translation>PNG, o TIFF con más de 8 bits</translation>
    </message>
    <message>
        <source>TIFF, the sensor&apos;s values</source>
        <translation>TIFF, los valores del sensor</translation>
    </message>
    <message>
        <source>Raw payload with a description</source>
        <translation>Datos sin procesar con una descripción</translation>
    </message>
</context>
<context>
    <name>SourceListView</name>
    <message>
        <source>A source by its address; Enter connects. Also gige:&lt;serial&gt; or gige:&lt;MAC&gt;.</source>
        <translation>Una fuente por su dirección; Intro conecta. También gige:&lt;n.º de serie&gt; o gige:&lt;MAC&gt;.</translation>
    </message>
    <message>
        <source>Address of a source</source>
        <translation>Dirección de una fuente</translation>
    </message>
    <message>
        <source>gige:192.168.0.10</source>
        <translation>gige:192.168.0.10</translation>
    </message>
    <message>
        <source>Search again now (F5)</source>
        <translation>Buscar de nuevo ahora (F5)</translation>
    </message>
    <message>
        <source>Search for sources again</source>
        <translation>Buscar fuentes de nuevo</translation>
    </message>
    <message>
        <source>Search</source>
        <translation>Buscar</translation>
    </message>
    <message>
        <source>F5</source>
        <translation>F5</translation>
    </message>
    <message>
        <source>Sources found; a double click or Enter connects</source>
        <translation>Fuentes halladas; un doble clic o Intro conecta</translation>
    </message>
    <message>
        <source>Sources found</source>
        <translation>Fuentes halladas</translation>
    </message>
    <message>
        <source>A real camera appears here once it is plugged in. If it does not, type its address above.</source>
        <translation>Una cámara real aparece aquí cuando se conecta. Si no aparece, escriba arriba su dirección.</translation>
    </message>
    <message>
        <source>Connect to the chosen source, or disconnect</source>
        <translation>Conectar con la fuente elegida o soltarla</translation>
    </message>
    <message>
        <source>Connect</source>
        <translation>Conectar</translation>
    </message>
    <message>
        <source>Open the chosen source in a tile; the current one stays open</source>
        <translation>Abrir la fuente elegida en una miniatura y dejar la otra como está</translation>
    </message>
    <message>
        <source>Open beside</source>
        <translation>Abrir al lado</translation>
    </message>
    <message>
        <source>Forget</source>
        <translation>Olvidar</translation>
    </message>
    <message>
        <source>Disconnect</source>
        <translation>Desconectar</translation>
    </message>
    <message>
        <source>Show</source>
        <translation>Mostrar</translation>
    </message>
    <message>
        <source>source</source>
        <translation>fuente</translation>
    </message>
    <message>
        <source>vendor</source>
        <translation>fabricante</translation>
    </message>
    <message>
        <source>model</source>
        <translation>modelo</translation>
    </message>
    <message>
        <source>name</source>
        <translation>nombre</translation>
    </message>
    <message>
        <source>serial</source>
        <translation>n.º de serie</translation>
    </message>
    <message>
        <source>address</source>
        <translation>dirección</translation>
    </message>
    <message>
        <source>version</source>
        <translation>versión</translation>
    </message>
    <message>
        <source>seen on</source>
        <translation>vista en</translation>
    </message>
    <message>
        <source>note</source>
        <translation>nota</translation>
    </message>
    <message>
        <source>Connect without starting</source>
        <translation>Conectar sin iniciar</translation>
    </message>
    <message>
        <source>Connect with a description file…</source>
        <translation>Conectar con un archivo de descripción…</translation>
    </message>
    <message>
        <source>IP address…</source>
        <translation>Dirección IP…</translation>
    </message>
    <message>
        <source>did not open</source>
        <translation>no se abrió</translation>
    </message>
</context>
<context>
    <name>Sources</name>
    <message>
        <source>serial {0}</source>
        <translation>n.º de serie {0}</translation>
    </message>
    <message>
        <source>lost, reconnecting</source>
        <translation>perdida, reconectando</translation>
    </message>
    <message>
        <source>connected</source>
        <translation>conectada</translation>
    </message>
    <message>
        <source>added by hand</source>
        <translation>añadida a mano</translation>
    </message>
    <message>
        <source>Simulated</source>
        <translation>Simulada</translation>
    </message>
    <message>
        <source>File</source>
        <translation>Archivo</translation>
    </message>
    <message>
        <source>did not open</source>
        <translation>no se abrió</translation>
    </message>
</context>
<context>
    <name>SourcesController</name>
    <message>
        <source>Connecting</source>
        <translation>Conectando</translation>
    </message>
    <message>
        <source>GenICam descriptions (*.xml *.zip)</source>
        <translation>Descripciones GenICam (*.xml *.zip)</translation>
    </message>
    <message>
        <source>Description of this camera</source>
        <translation>Descripción de esta cámara</translation>
    </message>
    <message>
        <source>The other program receives no more images: a recording there ends.</source>
        <translation>El otro programa deja de recibir imágenes: una grabación allí termina.</translation>
    </message>
    <message>
        <source>It is recording {0}; the recording ends.</source>
        <translation>Está grabando {0}; la grabación termina.</translation>
    </message>
    <message>
        <source>another program</source>
        <translation>otro programa</translation>
    </message>
    <message>
        <source>Take control of {0} from {1}?</source>
        <translation>¿Tomar el control de {0} a {1}?</translation>
    </message>
    <message>
        <source>Take control</source>
        <translation>Tomar el control</translation>
    </message>
    <message>
        <source>Leave it there</source>
        <translation>Dejarlo allí</translation>
    </message>
</context>
<context>
    <name>StateStrip</name>
    <message>
        <source>waiting</source>
        <translation>esperando</translation>
    </message>
</context>
<context>
    <name>Status</name>
    <message>
        <source>Not connected</source>
        <translation>Sin conexión</translation>
    </message>
    <message>
        <source>Connecting</source>
        <translation>Conectando</translation>
    </message>
    <message>
        <source>Stopped</source>
        <translation>Parada</translation>
    </message>
    <message>
        <source>Read only</source>
        <translation>Solo lectura</translation>
    </message>
    <message>
        <source>Starting</source>
        <translation>Arrancando</translation>
    </message>
    <message>
        <source>Live</source>
        <translation>En directo</translation>
    </message>
    <message>
        <source>Playing</source>
        <translation>Reproduciendo</translation>
    </message>
    <message>
        <source>Paused</source>
        <translation>En pausa</translation>
    </message>
    <message>
        <source>Waiting for trigger</source>
        <translation>Esperando disparo</translation>
    </message>
    <message>
        <source>No frame for {0:.0f} s</source>
        <translation>Sin imagen desde hace {0:.0f} s</translation>
    </message>
    <message>
        <source>Lost for {0:.0f} s</source>
        <translation>Perdida desde hace {0:.0f} s</translation>
    </message>
    <message>
        <source>{0} fps</source>
        <translation>{0} im/s</translation>
    </message>
    <message>
        <source>{0}, losing frames</source>
        <translation>{0}, pierde imágenes</translation>
    </message>
    <message>
        <source>● Recording</source>
        <translation>● Grabando</translation>
    </message>
    <message>
        <source>connection lost</source>
        <translation>conexión perdida</translation>
    </message>
</context>
<context>
    <name>StatusController</name>
    <message>
        <source>The camera does not answer; its last known settings are shown until it is back.</source>
        <translation>La cámara no responde; hasta que vuelva se muestra lo último que se ajustó.</translation>
    </message>
    <message>
        <source>Nothing is connected.</source>
        <translation>No hay nada conectado.</translation>
    </message>
    <message>
        <source>Connecting to {0} …</source>
        <translation>Conectando con {0} …</translation>
    </message>
    <message>
        <source>Waiting for a trigger</source>
        <translation>Esperando un disparo</translation>
    </message>
    <message>
        <source>The image goes to the program that has control.</source>
        <translation>La imagen va al programa que tiene el control.</translation>
    </message>
    <message>
        <source>The image goes to the program that has control: {0}.</source>
        <translation>La imagen va al programa que tiene el control: {0}.</translation>
    </message>
    <message>
        <source>Simulated camera</source>
        <translation>Cámara simulada</translation>
    </message>
    <message>
        <source>Type an address</source>
        <translation>Escribir dirección</translation>
    </message>
    <message>
        <source>Why is mine missing?</source>
        <translation>¿Por qué falta la mía?</translation>
    </message>
    <message>
        <source>Choose one of the sources (F8), or begin here:</source>
        <translation>Elija una de las fuentes (F8), o empiece aquí:</translation>
    </message>
</context>
<context>
    <name>StatusStrip</name>
    <message>
        <source>State of the connection and of the image</source>
        <translation>Estado de la conexión y de la imagen</translation>
    </message>
    <message>
        <source>Connection</source>
        <translation>Conexión</translation>
    </message>
    <message>
        <source>Resolution and pixel format of the newest frame</source>
        <translation>Resolución y formato de píxel de la última imagen</translation>
    </message>
    <message>
        <source>Resolution and pixel format</source>
        <translation>Resolución y formato de píxel</translation>
    </message>
    <message>
        <source>Frames per second from the camera, and images painted</source>
        <translation>Imágenes por segundo de la cámara y dibujadas</translation>
    </message>
    <message>
        <source>Frame rates</source>
        <translation>Frecuencias</translation>
    </message>
    <message>
        <source>Payload received per second</source>
        <translation>Datos recibidos por segundo</translation>
    </message>
    <message>
        <source>Bandwidth</source>
        <translation>Ancho de banda</translation>
    </message>
    <message>
        <source>Lost and incomplete frames, resent packets</source>
        <translation>Imágenes perdidas e incompletas, paquetes reenviados</translation>
    </message>
    <message>
        <source>Samples of the whole frame at the ends of the sensor’s range; a click marks them in the image (X)</source>
        <translation>Muestras de todo el fotograma en los extremos del rango del sensor; un clic las marca en la imagen (X)</translation>
    </message>
    <message>
        <source>Screen pixels for each pixel of the image</source>
        <translation>Píxeles de pantalla por cada píxel de la imagen</translation>
    </message>
    <message>
        <source>Zoom</source>
        <translation>Ampliación</translation>
    </message>
    <message>
        <source>{0} fps · {1} shown</source>
        <translation>{0} fps · {1} mostrados</translation>
    </message>
    <message>
        <source>Clipping</source>
        <translation>Recorte</translation>
    </message>
    <message>
        <source> · fitted</source>
        <translation> · encajada</translation>
    </message>
    <message>
        <source>{0} saturated</source>
        <translation>{0} saturado</translation>
    </message>
</context>
<context>
    <name>StreamHealth</name>
    <message>
        <source>more arrives than this computer can take</source>
        <translation>llega más de lo que este ordenador puede recibir</translation>
    </message>
    <message>
        <source>{0} resent</source>
        <translation>{0} reenviados</translation>
    </message>
    <message>
        <source>Frames since the start: {0}, lost {1}, incomplete {2}</source>
        <translation>Imágenes desde el inicio: {0}, perdidas {1}, incompletas {2}</translation>
    </message>
    <message>
        <source>Frames dropped because they were not taken in time: {0}</source>
        <translation>Imágenes descartadas porque nadie las recogió a tiempo: {0}</translation>
    </message>
    <message>
        <source>Packets: {0}, resent {1}, never arrived {2}</source>
        <translation>Paquetes: {0}, reenviados {1}, no llegaron nunca {2}</translation>
    </message>
    <message>
        <source>1 lost</source>
        <translation>1 perdida</translation>
    </message>
    <message>
        <source>{0} lost</source>
        <translation>{0} perdidas</translation>
    </message>
    <message>
        <source>1 incomplete</source>
        <translation>1 incompleta</translation>
    </message>
    <message>
        <source>{0} incomplete</source>
        <translation>{0} incompletas</translation>
    </message>
    <message>
        <source>{0:.1%} resent</source>
        <translation>{0:.1%} reenviado</translation>
    </message>
    <message>
        <source>1 resent</source>
        <translation>1 reenviado</translation>
    </message>
    <message>
        <source>All waiting packets discarded: {0}×; choose larger packets or a lower frame rate</source>
        <translation>Descartados todos los paquetes en espera: {0}×; elija paquetes más grandes o una frecuencia más baja</translation>
    </message>
    <message>
        <source>Packets refused, as they did not come from the camera: {0}</source>
        <translation>Paquetes rechazados por no venir de la cámara: {0}</translation>
    </message>
</context>
<context>
    <name>TaskRow</name>
    <message>
        <source>Progress</source>
        <translation>Progreso</translation>
    </message>
    <message>
        <source>Cancel</source>
        <translation>Cancelar</translation>
    </message>
</context>
<context>
    <name>Trigger</name>
    <message>
        <source>Waiting for trigger</source>
        <translation>Esperando disparo</translation>
    </message>
    <message>
        <source>Trigger on</source>
        <translation>Disparo activado</translation>
    </message>
    <message>
        <source>Waiting for trigger on {0}</source>
        <translation>Esperando disparo en {0}</translation>
    </message>
    <message>
        <source>Waiting for trigger from {0}</source>
        <translation>Esperando disparo de {0}</translation>
    </message>
    <message>
        <source>Trigger: {0}</source>
        <translation>Disparo: {0}</translation>
    </message>
    <message>
        <source>{0} sent</source>
        <translation>enviados: {0}</translation>
    </message>
    <message>
        <source>{0} accepted</source>
        <translation>aceptados: {0}</translation>
    </message>
    <message>
        <source>{0} missed</source>
        <translation>perdidos: {0}</translation>
    </message>
    <message>
        <source>The trigger failed: {0}</source>
        <translation>Falló el disparo: {0}</translation>
    </message>
</context>
<context>
    <name>TriggerBar</name>
    <message>
        <source>Trigger</source>
        <translation>Disparo</translation>
    </message>
    <message>
        <source>What triggers the camera</source>
        <translation>Qué dispara la cámara</translation>
    </message>
    <message>
        <source>Triggers sent, accepted and missed</source>
        <translation>Disparos enviados, aceptados y perdidos</translation>
    </message>
    <message>
        <source>Send</source>
        <translation>Enviar</translation>
    </message>
    <message>
        <source>Send one trigger</source>
        <translation>Enviar un disparo</translation>
    </message>
    <message>
        <source>Repeat every</source>
        <translation>Repetir cada</translation>
    </message>
    <message>
        <source>Send triggers again and again, in the distance beside it</source>
        <translation>Enviar disparos repetidamente, con el intervalo de al lado</translation>
    </message>
    <message>
        <source>Time between two triggers</source>
        <translation>Tiempo entre dos disparos</translation>
    </message>
    <message>
        <source>Time between two triggers that are sent</source>
        <translation>Tiempo entre dos disparos enviados</translation>
    </message>
    <message>
        <source>Trigger off</source>
        <translation>Desactivar disparo</translation>
    </message>
    <message>
        <source>Let the camera run freely</source>
        <translation>Dejar libre la cámara</translation>
    </message>
    <message>
        <source>What is wrong with the trigger</source>
        <translation>Qué falla en el disparo</translation>
    </message>
</context>
<context>
    <name>Tuning</name>
    <message>
        <source>no frame arrived to measure; start the camera, or its trigger, first</source>
        <translation>no llegó ninguna imagen que medir; inicie antes la cámara o su disparo</translation>
    </message>
    <message>
        <source>{0} was not done within {1:g} s; does the camera send frames?</source>
        <translation>{0} no terminó en {1:g} s; ¿envía imágenes la cámara?</translation>
    </message>
    <message>
        <source>{0} at work</source>
        <translation>{0} en marcha</translation>
    </message>
    <message>
        <source>{0:.0%} of white, aim {1:.0%} · {2}</source>
        <translation>{0:.0%} del blanco, objetivo {1:.0%} · {2}</translation>
    </message>
    <message>
        <source>Exposed: {0:.0%} of white with {1}</source>
        <translation>Expuesto: {0:.0%} del blanco con {1}</translation>
    </message>
    <message>
        <source>cancelled</source>
        <translation>cancelado</translation>
    </message>
    <message>
        <source>{0}: {1}; not everything could be restored: {2}</source>
        <translation>{0}: {1}; no todo está como antes: {2}</translation>
    </message>
    <message>
        <source>red {0:.0%}, blue {1:.0%} of green</source>
        <translation>rojo {0:.0%}, azul {1:.0%} del verde</translation>
    </message>
    <message>
        <source>Balanced: {0}</source>
        <translation>Equilibrado: {0}</translation>
    </message>
    <message>
        <source>As grey as it gets, with {0}; another light would help</source>
        <translation>Todo lo gris que puede ser, con {0}; ayudaría otra luz</translation>
    </message>
    <message>
        <source>the colour did not settle within {0} steps; is the scene moving, or the lamp flickering?</source>
        <translation>el color no se estabilizó en {0} pasos; ¿se mueve la escena o parpadea la lámpara?</translation>
    </message>
    <message>
        <source>there is no colour in this pixel format; choose an RGB or a Bayer format first</source>
        <translation>este formato de píxel no tiene color; elija antes uno RGB o Bayer</translation>
    </message>
    <message>
        <source>{0:.0%} of the region is saturated and has lost its colour; set the exposure first</source>
        <translation>el {0:.0%} de la región está saturado y ha perdido su color; ajuste antes la exposición</translation>
    </message>
    <message>
        <source>the region is too dark ({0:.1%} of white); set the exposure first</source>
        <translation>la región es demasiado oscura ({0:.1%} del blanco); ajuste antes la exposición</translation>
    </message>
    <message>
        <source>red {0}, blue {1}</source>
        <translation>rojo {0}, azul {1}</translation>
    </message>
    <message>
        <source>the camera was closed</source>
        <translation>se cerró la cámara</translation>
    </message>
    <message>
        <source>{0} did not answer within {1:g} s</source>
        <translation>{0} no respondió en {1:g} s</translation>
    </message>
    <message>
        <source>White balance set by the camera</source>
        <translation>Balance de blancos ajustado por la cámara</translation>
    </message>
    <message>
        <source>Exposure set by the camera: {0}</source>
        <translation>Exposición ajustada por la cámara: {0}</translation>
    </message>
    <message>
        <source>the light did not settle within {0} steps (it is at {1:.0%} of white); is the scene moving, or the lamp flickering?</source>
        <translation>la luz no se estabilizó en {0} pasos (está al {1:.0%} del blanco); ¿se mueve la escena o parpadea la lámpara?</translation>
    </message>
    <message>
        <source>As bright as it gets: {0:.0%} of white instead of {1:.0%}, with {2}; more light, or a lower frame rate, would help</source>
        <translation>Todo lo claro que puede ser: {0:.0%} del blanco en vez de {1:.0%}, con {2}; ayudaría más luz, o una frecuencia más baja</translation>
    </message>
    <message>
        <source>As dark as it gets: {0:.0%} of white instead of {1:.0%}, with {2}; less light would help</source>
        <translation>Todo lo oscuro que puede ser: {0:.0%} del blanco en vez de {1:.0%}, con {2}; ayudaría menos luz</translation>
    </message>
    <message>
        <source>the region has hardly any green ({0:.1%} of white), to which red and blue are adjusted; choose a grey one, in another light</source>
        <translation>la región apenas tiene verde ({0:.1%} del blanco), al que se ajustan el rojo y el azul; elija una gris, con otra luz</translation>
    </message>
</context>
<context>
    <name>TuningController</name>
    <message>
        <source>Exposure</source>
        <translation>Exposición</translation>
    </message>
    <message>
        <source>White balance</source>
        <translation>Balance de blancos</translation>
    </message>
    <message>
        <source>Exposure on a region</source>
        <translation>Exposición en una región</translation>
    </message>
    <message>
        <source>White balance on a region</source>
        <translation>Balance de blancos en una región</translation>
    </message>
</context>
<context>
    <name>Unavailable</name>
    <message>
        <source>No source is open: choose one in the list and connect to it.</source>
        <translation>No hay ninguna fuente abierta: elija una de la lista y conéctela.</translation>
    </message>
    <message>
        <source>The source is still being opened.</source>
        <translation>La fuente aún se está abriendo.</translation>
    </message>
    <message>
        <source>The source does not answer: wait until it is back.</source>
        <translation>La fuente no responde: espere a que vuelva.</translation>
    </message>
    <message>
        <source>The source is stopped: start it first.</source>
        <translation>La fuente está parada: iníciela primero.</translation>
    </message>
    <message>
        <source>The source is open for reading only: another program controls it.</source>
        <translation>La fuente está abierta solo para lectura: otro programa la controla.</translation>
    </message>
    <message>
        <source>The source is stopped already.</source>
        <translation>La fuente ya está parada.</translation>
    </message>
    <message>
        <source>A source is open: disconnect it first, or double-click another one in the list.</source>
        <translation>Hay una fuente abierta: desconéctela primero o haga doble clic en otra de la lista.</translation>
    </message>
    <message>
        <source>The source is open already: press “Show”, or click its tile.</source>
        <translation>La fuente ya está abierta: pulse «Mostrar» o su miniatura.</translation>
    </message>
    <message>
        <source>The source streams already.</source>
        <translation>La fuente ya está transmitiendo.</translation>
    </message>
    <message>
        <source>There is no frame yet: start the camera first.</source>
        <translation>Todavía no hay ninguna imagen: inicie antes la cámara.</translation>
    </message>
    <message>
        <source>The frame has no range image: enable the component Range, if there is one.</source>
        <translation>La imagen no tiene imagen de distancias: active el componente Range, si lo hay.</translation>
    </message>
    <message>
        <source>The camera reports no polarisers: if it has some, tick “Sensor has polarisers” below.</source>
        <translation>La cámara no informa de polarizadores: si los tiene, marque «El sensor tiene polarizadores» más abajo.</translation>
    </message>
    <message>
        <source>The source has neither exposure time nor gain.</source>
        <translation>La fuente no tiene ni tiempo de exposición ni ganancia.</translation>
    </message>
    <message>
        <source>The source has no white balance.</source>
        <translation>La fuente no tiene balance de blancos.</translation>
    </message>
    <message>
        <source>The source has no region of interest that can be changed.</source>
        <translation>La fuente no tiene una región de interés que se pueda cambiar.</translation>
    </message>
    <message>
        <source>The source keeps no user sets: save its settings in a file.</source>
        <translation>La fuente no guarda conjuntos de ajustes: guarde sus ajustes en un archivo.</translation>
    </message>
    <message>
        <source>The source has no look-up table that can be read.</source>
        <translation>La fuente no tiene una tabla de consulta que se pueda leer.</translation>
    </message>
    <message>
        <source>The source has no calibration: load one, or calibrate the camera.</source>
        <translation>La fuente no tiene calibración: cargue una o calibre la cámara.</translation>
    </message>
    <message>
        <source>Nothing was changed since the source was opened.</source>
        <translation>No se ha cambiado nada desde que se abrió la fuente.</translation>
    </message>
    <message>
        <source>Nothing was undone.</source>
        <translation>No se ha deshecho nada.</translation>
    </message>
    <message>
        <source>The list is empty.</source>
        <translation>La lista está vacía.</translation>
    </message>
    <message>
        <source>Wait until the present run has ended.</source>
        <translation>Espere a que termine el ajuste en curso.</translation>
    </message>
    <message>
        <source>A search is in progress.</source>
        <translation>Hay una búsqueda en curso.</translation>
    </message>
    <message>
        <source>Choose a source in the list, or type its address above.</source>
        <translation>Elija una fuente de la lista o escriba su dirección arriba.</translation>
    </message>
    <message>
        <source>The whole image is measured already.</source>
        <translation>Ya se mide la imagen completa.</translation>
    </message>
    <message>
        <source>Choose a set in the list.</source>
        <translation>Elija un conjunto de la lista.</translation>
    </message>
    <message>
        <source>This set cannot be changed: choose another one.</source>
        <translation>Este conjunto no se puede cambiar: elija otro.</translation>
    </message>
    <message>
        <source>The camera starts with this set already, or cannot start with it.</source>
        <translation>La cámara ya arranca con este conjunto, o no puede arrancar con él.</translation>
    </message>
    <message>
        <source>Nothing was edited.</source>
        <translation>No se ha editado nada.</translation>
    </message>
    <message>
        <source>This control is the first one already.</source>
        <translation>Este control ya es el primero.</translation>
    </message>
    <message>
        <source>This control is the last one already.</source>
        <translation>Este control ya es el último.</translation>
    </message>
    <message>
        <source>This is the first page.</source>
        <translation>Esta es la primera página.</translation>
    </message>
    <message>
        <source>There are too few views yet.</source>
        <translation>Aún hay muy pocas vistas.</translation>
    </message>
    <message>
        <source>Tick the box above first.</source>
        <translation>Marque antes la casilla de arriba.</translation>
    </message>
    <message>
        <source>A chessboard has no markers.</source>
        <translation>Un tablero de ajedrez no tiene marcadores.</translation>
    </message>
    <message>
        <source>A single marker has no rows and columns.</source>
        <translation>Un solo marcador no tiene filas ni columnas.</translation>
    </message>
    <message>
        <source>The name is published: stop publishing it first.</source>
        <translation>El nombre está publicado: deje antes de publicarlo.</translation>
    </message>
    <message>
        <source>Hand and eye of this robot cannot be calibrated here.</source>
        <translation>Aquí no se pueden calibrar mano y ojo de este robot.</translation>
    </message>
    <message>
        <source>The camera does not offer this now.</source>
        <translation>La cámara no lo ofrece ahora.</translation>
    </message>
    <message>
        <source>The source is no rig: “New rig…” makes one of several cameras.</source>
        <translation>La fuente no es un grupo: «Nuevo grupo de cámaras…» hace uno de varias cámaras.</translation>
    </message>
    <message>
        <source>The source has no files.</source>
        <translation>La fuente no tiene archivos.</translation>
    </message>
    <message>
        <source>Choose a file in the list.</source>
        <translation>Elija un archivo de la lista.</translation>
    </message>
    <message>
        <source>Files are transferred only by a computer that has the camera itself.</source>
        <translation>Solo transfiere archivos el ordenador que tiene la cámara conectada.</translation>
    </message>
    <message>
        <source>The camera does not let this file be read.</source>
        <translation>La cámara no permite leer este archivo.</translation>
    </message>
    <message>
        <source>The camera does not let this file be written.</source>
        <translation>La cámara no permite escribir este archivo.</translation>
    </message>
    <message>
        <source>Firmware is never deleted.</source>
        <translation>El firmware nunca se elimina.</translation>
    </message>
    <message>
        <source>The source reports no events. Those of a rig are in “Rig…”.</source>
        <translation>La fuente no comunica eventos. Los de un grupo están en «Grupo de cámaras…».</translation>
    </message>
</context>
<context>
    <name>UserSetsController</name>
    <message>
        <source>Settings kept in the camera</source>
        <translation>Ajustes guardados en la cámara</translation>
    </message>
    <message>
        <source>Loading a set of the camera</source>
        <translation>Cargando un juego de la cámara</translation>
    </message>
    <message>
        <source>Saved the current settings in the camera as {0}</source>
        <translation>Ajustes actuales guardados en la cámara como {0}</translation>
    </message>
    <message>
        <source>Saving in the camera</source>
        <translation>Guardando en la cámara</translation>
    </message>
    <message>
        <source>The camera starts with {0} from its next power-on</source>
        <translation>La cámara arrancará con {0} la próxima vez que se encienda</translation>
    </message>
    <message>
        <source>Writing to the camera</source>
        <translation>Escribiendo en la cámara</translation>
    </message>
    <message>
        <source>1 setting</source>
        <translation>1 ajuste</translation>
    </message>
    <message>
        <source>{0} settings</source>
        <translation>{0} ajustes</translation>
    </message>
    <message>
        <source>Loaded {0}: changed {1}</source>
        <translation>Cargado {0}: ha cambiado {1}</translation>
    </message>
</context>
<context>
    <name>UserSetsDialog</name>
    <message>
        <source>Settings kept in the camera</source>
        <translation>Ajustes guardados en la cámara</translation>
    </message>
    <message>
        <source>The camera keeps these sets in its own memory, also without power.</source>
        <translation>La propia cámara conserva estos juegos, también sin corriente.</translation>
    </message>
    <message>
        <source>Sets of settings</source>
        <translation>Juegos de ajustes</translation>
    </message>
    <message>
        <source>Load this set; this can be undone</source>
        <translation>Ajustar la cámara según este juego; se puede deshacer</translation>
    </message>
    <message>
        <source>&amp;Load</source>
        <translation>&amp;Cargar</translation>
    </message>
    <message>
        <source>Save the current settings in this set, which overwrites it</source>
        <translation>Guardar los ajustes actuales en este juego; lo que contenía se pierde</translation>
    </message>
    <message>
        <source>&amp;Save here</source>
        <translation>&amp;Guardar aquí</translation>
    </message>
    <message>
        <source>Let the camera start with this set from its next power-on</source>
        <translation>Que la cámara arranque con este juego la próxima vez que se encienda</translation>
    </message>
    <message>
        <source>S&amp;tart with this</source>
        <translation>&amp;Arrancar con este</translation>
    </message>
    <message>
        <source>Close</source>
        <translation>Cerrar</translation>
    </message>
    <message>
        <source>{0}  ·  the camera starts with it</source>
        <translation>{0}  ·  la cámara arranca con él</translation>
    </message>
    <message>
        <source>Save the current settings in {0}?</source>
        <translation>¿Guardar los ajustes actuales en {0}?</translation>
    </message>
    <message>
        <source>This overwrites the set and cannot be undone.</source>
        <translation>Lo que contenía se pierde; no se puede deshacer.</translation>
    </message>
    <message>
        <source>Overwrite</source>
        <translation>Sobrescribir</translation>
    </message>
</context>
<context>
    <name>ValueSlider</name>
    <message>
        <source>{0} … {1}; hold the handle beyond an end to move the range.</source>
        <translation>{0} … {1}; mantenga el control más allá de un extremo para seguir.</translation>
    </message>
</context>
<context>
    <name>ValuesController</name>
    <message>
        <source>no more than {0} values can be plotted at once; remove one first</source>
        <translation>no se pueden representar más de {0} valores a la vez; quite antes uno</translation>
    </message>
    <message>
        <source>Saved the values to {0}</source>
        <translation>Valores guardados en {0}</translation>
    </message>
    <message>
        <source>Save values</source>
        <translation>Guardar valores</translation>
    </message>
    <message>
        <source>Comma-separated values (*.csv)</source>
        <translation>Valores separados por comas (*.csv)</translation>
    </message>
</context>
<context>
    <name>ValuesPanel</name>
    <message>
        <source>Time span of the plot</source>
        <translation>Cuánto del pasado se muestra</translation>
    </message>
    <message>
        <source>Time shown</source>
        <translation>Tiempo mostrado</translation>
    </message>
    <message>
        <source>Last 10 s</source>
        <translation>Últimos 10 s</translation>
    </message>
    <message>
        <source>Last minute</source>
        <translation>Último minuto</translation>
    </message>
    <message>
        <source>Last 10 min</source>
        <translation>Últimos 10 min</translation>
    </message>
    <message>
        <source>Last hour</source>
        <translation>Última hora</translation>
    </message>
    <message>
        <source>Pause reading the values</source>
        <translation>Dejar de leer los valores un rato</translation>
    </message>
    <message>
        <source>Pause</source>
        <translation>Pausa</translation>
    </message>
    <message>
        <source>Save everything that was read as a table of comma-separated values</source>
        <translation>Guardar todo lo leído como tabla de valores separados por comas</translation>
    </message>
    <message>
        <source>Save…</source>
        <translation>Guardar…</translation>
    </message>
    <message>
        <source>Clear the values, and continue</source>
        <translation>Olvidar lo leído y seguir</translation>
    </message>
    <message>
        <source>Clear</source>
        <translation>Vaciar</translation>
    </message>
    <message>
        <source>Right-click a feature and choose “Plot over time”.</source>
        <translation>Pulse un parámetro con el botón derecho y elija «Representar en el tiempo».</translation>
    </message>
    <message>
        <source>Show all curves in one plot, each with a range of its own</source>
        <translation>Superponer todas las curvas, cada una en su propio rango</translation>
    </message>
    <message>
        <source>In one plot</source>
        <translation>En un solo gráfico</translation>
    </message>
    <message>
        <source>All curves over time</source>
        <translation>Todas las curvas en el tiempo</translation>
    </message>
</context>
</TS>
