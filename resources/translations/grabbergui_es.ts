<?xml version="1.0" encoding="utf-8"?>
<!DOCTYPE TS>
<TS version="2.1">
<context>
    <name>AcquisitionController</name>
    <message>
        <location filename="../../grabbergui/ui/controllers/image.py" line="103"/>
        <source>there is no frame to save yet; start the camera first</source>
        <translation>todavía no hay imagen que capturar; inicie antes la cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/image.py" line="171"/>
        <source>Saved {0}</source>
        <translation>Guardado {0}</translation>
    </message>
</context>
<context>
    <name>AutoButton</name>
    <message>
        <location filename="../../grabbergui/ui/editors/auto_button.py" line="51"/>
        <source>Auto</source>
        <translation>Autom.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/editors/auto_button.py" line="51"/>
        <source>Once</source>
        <translation>Una vez</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/editors/auto_button.py" line="57"/>
        <source>{0}
It {1}.</source>
        <translation>{0}
({1}.)</translation>
    </message>
</context>
<context>
    <name>Calibrating</name>
    <message>
        <location filename="../../grabbergui/models/calibrating.py" line="296"/>
        <source>no board is seen</source>
        <translation>no se ve ningún tablero</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/calibrating.py" line="297"/>
        <source>hold it still</source>
        <translation>manténgalo quieto</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/calibrating.py" line="298"/>
        <source>this view is there already</source>
        <translation>esta vista ya está</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/calibrating.py" line="299"/>
        <source>kept</source>
        <translation>guardada</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/calibrating.py" line="306"/>
        <source>Everything is covered</source>
        <translation>Todo está cubierto</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/calibrating.py" line="308"/>
        <source>Next: tilt it, its left edge nearer</source>
        <translation>Ahora: inclínelo, con el borde izquierdo más cerca</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/calibrating.py" line="309"/>
        <source>Next: tilt it, its right edge nearer</source>
        <translation>Ahora: inclínelo, con el borde derecho más cerca</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/calibrating.py" line="310"/>
        <source>Next: tilt it, its upper edge nearer</source>
        <translation>Ahora: inclínelo, con el borde superior más cerca</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/calibrating.py" line="311"/>
        <source>Next: tilt it, its lower edge nearer</source>
        <translation>Ahora: inclínelo, con el borde inferior más cerca</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/calibrating.py" line="312"/>
        <source>Next: hold it at the top left</source>
        <translation>Ahora: arriba a la izquierda</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/calibrating.py" line="313"/>
        <source>Next: hold it at the top</source>
        <translation>Ahora: arriba</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/calibrating.py" line="314"/>
        <source>Next: hold it at the top right</source>
        <translation>Ahora: arriba a la derecha</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/calibrating.py" line="315"/>
        <source>Next: hold it at the left</source>
        <translation>Ahora: a la izquierda</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/calibrating.py" line="316"/>
        <source>Next: hold it in the middle</source>
        <translation>Ahora: en el centro</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/calibrating.py" line="317"/>
        <source>Next: hold it at the right</source>
        <translation>Ahora: a la derecha</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/calibrating.py" line="318"/>
        <source>Next: hold it at the bottom left</source>
        <translation>Ahora: abajo a la izquierda</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/calibrating.py" line="319"/>
        <source>Next: hold it at the bottom</source>
        <translation>Ahora: abajo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/calibrating.py" line="320"/>
        <source>Next: hold it at the bottom right</source>
        <translation>Ahora: abajo a la derecha</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/calibrating.py" line="321"/>
        <source>Next: hold it nearer</source>
        <translation>Ahora: más cerca</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/calibrating.py" line="322"/>
        <source>Next: hold it farther away</source>
        <translation>Ahora: más lejos</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/calibrating.py" line="199"/>
        <source>there is no calibration to save yet</source>
        <translation>todavía no hay ninguna calibración que guardar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/calibrating.py" line="204"/>
        <source>the calibration could not be saved: {0}</source>
        <translation>no se pudo guardar la calibración: {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/calibrating.py" line="226"/>
        <source>frame {0} cannot be evaluated: {1}</source>
        <translation>no se puede evaluar el fotograma {0}: {1}</translation>
    </message>
</context>
<context>
    <name>CalibratingController</name>
    <message>
        <location filename="../../grabbergui/ui/controllers/calibration_dialogs.py" line="77"/>
        <source>the board could not be saved: {0}</source>
        <translation>no se pudo guardar el tablero: {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/calibration_dialogs.py" line="79"/>
        <source>Saved as {0}: print it on {1} at 100 %</source>
        <translation>Guardado como {0}: imprímalo en {1} al 100 %</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/calibration_dialogs.py" line="124"/>
        <source>Save the board</source>
        <translation>Guardar el tablero</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/calibration_dialogs.py" line="130"/>
        <source>Save the calibration</source>
        <translation>Guardar la calibración</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/calibration_dialogs.py" line="156"/>
        <source>Saved as {0}. Publish it with `grabbergui serve … --ros2 NAME --calibration {0}`</source>
        <translation>Guardada como {0}. Publíquela con `grabbergui serve … --ros2 NAME --calibration {0}`</translation>
    </message>
</context>
<context>
    <name>CalibrationChoiceDialog</name>
    <message>
        <location filename="../../grabbergui/ui/forms/calibration_choice.ui" line="6"/>
        <source>The camera is not calibrated</source>
        <translation>La cámara no está calibrada</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/calibration_choice.ui" line="15"/>
        <source>Positions are computed from the calibration of the lens. Without one nothing moves.</source>
        <translation>Las posiciones se calculan a partir de la calibración del objetivo. Sin ella nada se mueve.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/calibration_choice.ui" line="18"/>
        <source>&amp;Calibrate it now</source>
        <translation>&amp;Calibrarla ahora</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/calibration_choice.ui" line="19"/>
        <source>With a printed board; takes about two minutes.</source>
        <translation>Con un tablero impreso; lleva unos dos minutos.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/calibration_choice.ui" line="23"/>
        <source>&amp;Open a calibration…</source>
        <translation>&amp;Abrir una calibración…</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/calibration_choice.ui" line="24"/>
        <source>A camera_info file, of this camera with this lens and focus.</source>
        <translation>Un archivo camera_info de esta cámara, con este objetivo y este enfoque.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/calibration_choice.ui" line="30"/>
        <source>&amp;Assume a field of view</source>
        <translation>&amp;Suponer un campo de visión</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/calibration_choice.ui" line="31"/>
        <source>Directions are about right, distances rough.</source>
        <translation>Las direcciones son casi exactas; las distancias, aproximadas.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/calibration_choice.ui" line="35"/>
        <source>Field of view</source>
        <translation>Campo de visión</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/calibration_choice.ui" line="36"/>
        <source>Horizontal angle that the image covers</source>
        <translation>Ángulo horizontal que abarca la imagen</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/calibration_choice.ui" line="37"/>
        <source>°</source>
        <translation>°</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/calibration_choice.ui" line="50"/>
        <source>Cancel</source>
        <translation>Cancelar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/calibration_dialogs.py" line="386"/>
        <source>{0} is not calibrated</source>
        <translation>{0} no está calibrada</translation>
    </message>
</context>
<context>
    <name>CalibrationChooser</name>
    <message>
        <location filename="../../grabbergui/ui/controllers/calibration_dialogs.py" line="206"/>
        <source>Open a calibration</source>
        <translation>Abrir una calibración</translation>
    </message>
</context>
<context>
    <name>CalibrationDialog</name>
    <message>
        <location filename="../../grabbergui/ui/forms/calibration.ui" line="6"/>
        <source>Calibrate the camera</source>
        <translation>Calibrar la cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/calibration.ui" line="31"/>
        <source>● waiting for an image</source>
        <translation>● esperando una imagen</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/calibration.ui" line="61"/>
        <source>Which board do you use? A ChArUco board may extend beyond the image and so covers its corners; a chessboard must be seen whole.</source>
        <translation>¿Qué tablero se muestra? Un tablero ChArUco puede salirse de la imagen y así llega a las esquinas; un tablero de ajedrez debe verse entero.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/calibration.ui" line="65"/>
        <source>&amp;Board</source>
        <translation>&amp;Tablero</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/calibration.ui" line="67"/>
        <source>ChArUco</source>
        <translation>ChArUco</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/calibration.ui" line="68"/>
        <source>Chessboard</source>
        <translation>Tablero de ajedrez</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/calibration.ui" line="70"/>
        <source>Squares a&amp;cross</source>
        <translation>Casillas a lo a&amp;ncho</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/calibration.ui" line="72"/>
        <source>Squares &amp;down</source>
        <translation>Casillas a lo a&amp;lto</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/calibration.ui" line="74"/>
        <source>Edge of a &amp;field</source>
        <translation>Lado de una &amp;casilla</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/calibration.ui" line="75"/>
        <source>As measured on the paper; it sets the scale of all distances</source>
        <translation>Medido sobre el papel: las distancias serán tan exactas como esta medida</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/calibration.ui" line="77"/>
        <source> mm</source>
        <translation> mm</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/calibration.ui" line="76"/>
        <source>Edge of a &amp;marker</source>
        <translation>Lado de un &amp;marcador</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/calibration.ui" line="78"/>
        <source>D&amp;ictionary</source>
        <translation>&amp;Diccionario</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/calibration.ui" line="83"/>
        <source>Save the board for &amp;printing…</source>
        <translation>Guardar el tablero para im&amp;primirlo…</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/calibration.ui" line="84"/>
        <source>PDF or PNG at true scale; print at 100 %, and measure the rule</source>
        <translation>PDF o PNG a escala real; imprímalo al 100 % y mida la regla</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/calibration.ui" line="89"/>
        <source>Print it at 100 %, check the rule, and glue it onto something flat and stiff: paper that bends spoils the result.</source>
        <translation>Imprímalo al 100 %, compruebe la regla y péguelo sobre algo plano y rígido: un papel que se dobla estropea el resultado.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/calibration.ui" line="101"/>
        <source>Hold the board still for a moment, then elsewhere: near and far, in every corner of the image, tilted every way. Views are taken automatically.</source>
        <translation>Mantenga quieto el tablero un momento y muévalo a otro lugar: cerca y lejos, en cada esquina de la imagen, inclinado de todas las maneras. Las vistas se toman solas.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/calibration.ui" line="109"/>
        <source>%v of %m views</source>
        <translation>%v de %m vistas</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/calibration.ui" line="118"/>
        <source>&amp;Begin again</source>
        <translation>&amp;Empezar de nuevo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/calibration.ui" line="119"/>
        <source>Discard the views taken so far</source>
        <translation>Olvidar las vistas tomadas hasta ahora</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/calibration_dialogs.py" line="182"/>
        <source>Views</source>
        <translation>Vistas</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/calibration.ui" line="133"/>
        <source>Untick a view to leave it out; choose one to see it, its errors enlarged</source>
        <translation>Desmarque una vista para excluirla; elija una para verla con sus errores ampliados</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/calibration.ui" line="136"/>
        <source>View</source>
        <translation>Vista</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/calibration.ui" line="137"/>
        <source>Corners</source>
        <translation>Esquinas</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/calibration_dialogs.py" line="238"/>
        <source>Error</source>
        <translation>Error</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/calibration.ui" line="141"/>
        <source>Take &amp;more views</source>
        <translation>Tomar &amp;más vistas</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/calibration.ui" line="149"/>
        <source>Bac&amp;k</source>
        <translation>&amp;Atrás</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/calibration.ui" line="151"/>
        <source>Close</source>
        <translation>Cerrar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/calibration.ui" line="152"/>
        <source>&amp;Next</source>
        <translation>&amp;Siguiente</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/calibration_dialogs.py" line="220"/>
        <source>no images arrive from the camera</source>
        <translation>la cámara no envía imágenes</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/calibration_dialogs.py" line="355"/>
        <source>the board is seen</source>
        <translation>se ve el tablero</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/calibration_dialogs.py" line="182"/>
        <source>Board</source>
        <translation>Tablero</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/calibration_dialogs.py" line="182"/>
        <source>Result</source>
        <translation>Resultado</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/calibration_dialogs.py" line="185"/>
        <source>Take &amp;views</source>
        <translation>Tomar &amp;vistas</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/calibration_dialogs.py" line="185"/>
        <source>&amp;Finish</source>
        <translation>&amp;Terminar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/calibration_dialogs.py" line="185"/>
        <source>&amp;Save…</source>
        <translation>&amp;Guardar…</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/calibration_dialogs.py" line="227"/>
        <source>{0:.0%} of the image is covered</source>
        <translation>Está cubierto el {0:.0%} de la imagen</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/calibration_dialogs.py" line="238"/>
        <source>&lt;b&gt;{0:.3f} px&lt;/b&gt; over {1} views</source>
        <translation>&lt;b&gt;{0:.3f} px&lt;/b&gt; en {1} vistas</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/calibration_dialogs.py" line="238"/>
        <source>Focal lengths</source>
        <translation>Distancias focales</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/calibration_dialogs.py" line="238"/>
        <source>Centre</source>
        <translation>Centro</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/calibration_dialogs.py" line="238"/>
        <source>Distortion</source>
        <translation>Distorsión</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/calibration_dialogs.py" line="267"/>
        <source>{0}, left out</source>
        <translation>{0}, excluida</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/calibration_dialogs.py" line="279"/>
        <source>view {0}, errors enlarged {1} times</source>
        <translation>vista {0}, errores ampliados {1} veces</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/calibration.ui" line="21"/>
        <source>Live image</source>
        <translation>Imagen en directo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/calibration.ui" line="114"/>
        <source>Tilts and distances that were seen</source>
        <translation>Inclinaciones y distancias vistas</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/calibration_dialogs.py" line="298"/>
        <source>Discard {0} views?</source>
        <translation>¿Descartar {0} vistas?</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/calibration_dialogs.py" line="298"/>
        <source>The calibration that is computed from them has not been saved.</source>
        <translation>La calibración calculada a partir de ellas no se ha guardado.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/calibration_dialogs.py" line="304"/>
        <source>Discard them</source>
        <translation>Descartarlas</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/calibration_dialogs.py" line="305"/>
        <source>Keep them</source>
        <translation>Conservarlas</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/calibration_dialogs.py" line="298"/>
        <source>Discard the view?</source>
        <translation>¿Descartar la vista?</translation>
    </message>
</context>
<context>
    <name>CalibrationViewController</name>
    <message>
        <location filename="../../grabbergui/ui/controllers/calibration.py" line="163"/>
        <source>Load a calibration</source>
        <translation>Cargar una calibración</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/calibration.py" line="154"/>
        <source>{0}: the image is shown undistorted, {1:.0f}° × {2:.0f}°</source>
        <translation>{0}: la imagen se muestra sin distorsión, {1:.0f}° × {2:.0f}°</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/calibration.py" line="157"/>
        <source>{0} was made with another camera, {1} {2}; calibrate this one as well</source>
        <translation>{0} se hizo con otra cámara, {1} {2}; calibre también esta</translation>
    </message>
</context>
<context>
    <name>CameraEventsDialog</name>
    <message>
        <location filename="../../grabbergui/ui/forms/camera_events.ui" line="6"/>
        <source>Events of the camera</source>
        <translation>Eventos de la cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/camera_events.ui" line="10"/>
        <source>Tick the events that the camera should report. They are marks on the curves of values, too.</source>
        <translation>Marque los eventos que la cámara debe comunicar. También son marcas en las curvas.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/camera_events.ui" line="21"/>
        <source>Events that the camera can report</source>
        <translation>Eventos que la cámara puede comunicar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/camera_events.ui" line="25"/>
        <source>Events that arrived, the newest first</source>
        <translation>Eventos recibidos, el más reciente primero</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/camera_events.ui" line="28"/>
        <source>Time</source>
        <translation>Hora</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/camera_events.ui" line="29"/>
        <source>Event</source>
        <translation>Evento</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/camera_events.ui" line="30"/>
        <source>Values</source>
        <translation>Valores</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/camera_events.ui" line="37"/>
        <source>C&amp;lear</source>
        <translation>&amp;Vaciar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/camera_events.ui" line="38"/>
        <source>&amp;Copy</source>
        <translation>&amp;Copiar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/camera_events.ui" line="39"/>
        <source>Close</source>
        <translation>Cerrar</translation>
    </message>
</context>
<context>
    <name>CameraTile</name>
    <message>
        <location filename="../../grabbergui/ui/forms/camera_tile.ui" line="29"/>
        <source>Close</source>
        <translation>Cerrar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/camera_tile.ui" line="30"/>
        <source>Close this source</source>
        <translation>Cerrar esta fuente</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/gallery.py" line="101"/>
        <source>Close {0}</source>
        <translation>Cerrar {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/gallery.py" line="118"/>
        <source>This is the current source</source>
        <translation>Esta es la fuente activa</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/gallery.py" line="118"/>
        <source>Make this the current source</source>
        <translation>Hacer activa esta fuente</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/camera_tile.ui" line="44"/>
        <source>This source is being recorded</source>
        <translation>Esta fuente se está grabando</translation>
    </message>
</context>
<context>
    <name>CameraWork</name>
    <message>
        <location filename="../../grabbergui/ui/controllers/camera_work.py" line="79"/>
        <source>there is no camera; connect to one first</source>
        <translation>no hay ninguna cámara; conéctese antes a una</translation>
    </message>
</context>
<context>
    <name>ChangeTable</name>
    <message>
        <location filename="../../grabbergui/ui/views/changes_panel.py" line="54"/>
        <source>Time</source>
        <translation>Hora</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/changes_panel.py" line="54"/>
        <source>Feature</source>
        <translation>Parámetro</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/changes_panel.py" line="54"/>
        <source>Before</source>
        <translation>Antes</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/changes_panel.py" line="54"/>
        <source>After</source>
        <translation>Después</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/changes_panel.py" line="54"/>
        <source>By</source>
        <translation>Por</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/changes_panel.py" line="54"/>
        <source>Part of</source>
        <translation>Parte de</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/changes_panel.py" line="64"/>
        <source>operator</source>
        <translation>operador</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/changes_panel.py" line="65"/>
        <source>camera</source>
        <translation>cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/changes_panel.py" line="66"/>
        <source>network</source>
        <translation>red</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/changes_panel.py" line="104"/>
        <source>run</source>
        <translation>ejecutado</translation>
    </message>
</context>
<context>
    <name>Changes</name>
    <message>
        <location filename="../../grabbergui/models/undo_steps.py" line="40"/>
        <source>Undo</source>
        <translation>Deshacer</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/undo_steps.py" line="40"/>
        <source>Redo</source>
        <translation>Rehacer</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/change_tracking.py" line="179"/>
        <source>{0} of {1}: {2}</source>
        <translation>{0} {1}: {2}</translation>
    </message>
</context>
<context>
    <name>ChangesController</name>
    <message>
        <location filename="../../grabbergui/ui/controllers/changes.py" line="87"/>
        <source>&amp;Undo</source>
        <translation>&amp;Deshacer</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/changes.py" line="87"/>
        <source>&amp;Redo</source>
        <translation>&amp;Rehacer</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/changes.py" line="118"/>
        <source>Save changes</source>
        <translation>Guardar los cambios</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/changes.py" line="117"/>
        <source>Python program (*.py);;Shell script (*.sh);;Table (*.tsv)</source>
        <translation>Programa de Python (*.py);;Script de shell (*.sh);;Tabla (*.tsv)</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/changes.py" line="125"/>
        <source>Saved the changes to {0}</source>
        <translation>Cambios guardados en {0}</translation>
    </message>
</context>
<context>
    <name>ChangesPanel</name>
    <message>
        <location filename="../../grabbergui/ui/forms/changes_panel.ui" line="21"/>
        <source>Show the changes of</source>
        <translation>De quién son los cambios que se muestran</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/changes_panel.ui" line="22"/>
        <source>Whose changes</source>
        <translation>Cambios de quién</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/changes_panel.ui" line="23"/>
        <source>Everybody’s changes</source>
        <translation>Cambios de todos</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/changes_panel.ui" line="25"/>
        <source>The operator’s changes</source>
        <translation>Cambios del operador</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/changes_panel.ui" line="47"/>
        <source>Copy the selected changes, or else all shown, in a form that repeats them</source>
        <translation>Copiar lo seleccionado, o si no todo lo mostrado, como algo que repite los cambios</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/changes_panel.ui" line="48"/>
        <source>Copy as</source>
        <translation>Copiar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/changes_panel.ui" line="53"/>
        <source>Save the selected changes, or else all shown: a Python program, a shell script or a table</source>
        <translation>Guardar lo seleccionado, o si no todo lo mostrado: programa de Python, script de shell o tabla</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/changes_panel.ui" line="54"/>
        <source>Save…</source>
        <translation>Guardar…</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/changes_panel.ui" line="30"/>
        <source>Clear the list; steps can still be undone</source>
        <translation>Olvidar la lista; lo que se puede deshacer se conserva</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/changes_panel.ui" line="31"/>
        <source>Clear</source>
        <translation>Vaciar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/changes_panel.ui" line="63"/>
        <source>Changes</source>
        <translation>Cambios</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/changes_panel.py" line="208"/>
        <source>&amp;Command line</source>
        <translation>&amp;Línea de órdenes</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/changes_panel.py" line="208"/>
        <source>&amp;Python program</source>
        <translation>Programa de &amp;Python</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/changes_panel.py" line="208"/>
        <source>&amp;Table</source>
        <translation>&amp;Tabla</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/changes_panel.ui" line="24"/>
        <source>Without the camera’s own</source>
        <translation>Sin los de la propia cámara</translation>
    </message>
</context>
<context>
    <name>CodedNumberEditor</name>
    <message>
        <location filename="../../grabbergui/ui/editors/feature_editor.py" line="202"/>
        <source>“{0}” is not an IPv4 address</source>
        <translation>«{0}» no es una dirección IPv4</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/editors/feature_editor.py" line="204"/>
        <source>“{0}” is not a MAC address</source>
        <translation>«{0}» no es una dirección MAC</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/editors/feature_editor.py" line="206"/>
        <source>“{0}” is not a number</source>
        <translation>«{0}» no es un número</translation>
    </message>
</context>
<context>
    <name>CommandEditor</name>
    <message>
        <location filename="../../grabbergui/ui/editors/feature_editor.py" line="89"/>
        <source>Run</source>
        <translation>Ejecutar</translation>
    </message>
</context>
<context>
    <name>Components</name>
    <message>
        <location filename="../../grabbergui/models/image/components.py" line="39"/>
        <source>Intensity</source>
        <translation>Intensidad</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/image/components.py" line="40"/>
        <source>Infrared</source>
        <translation>Infrarrojo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/image/components.py" line="41"/>
        <source>Ultraviolet</source>
        <translation>Ultravioleta</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/image/components.py" line="42"/>
        <source>Range</source>
        <translation>Distancia</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/image/components.py" line="43"/>
        <source>Reflectance</source>
        <translation>Reflectancia</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/image/components.py" line="44"/>
        <source>Confidence</source>
        <translation>Confianza</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/image/components.py" line="45"/>
        <source>Scatter</source>
        <translation>Dispersión</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/image/components.py" line="46"/>
        <source>Disparity</source>
        <translation>Disparidad</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/image/components.py" line="47"/>
        <source>Multispectral</source>
        <translation>Multiespectral</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/image/components.py" line="48"/>
        <source>Component</source>
        <translation>Componente</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/image/components.py" line="31"/>
        <source>{0}, source {1}</source>
        <translation>{0}, fuente {1}</translation>
    </message>
</context>
<context>
    <name>Connection</name>
    <message>
        <location filename="../../grabbergui/models/source_opener.py" line="112"/>
        <source>{0} is open already</source>
        <translation>{0} ya está abierta</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/stream_control.py" line="55"/>
        <source>stopping failed: {0}</source>
        <translation>no se pudo parar: {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/stream_control.py" line="40"/>
        <source>{0} does not start: {1}</source>
        <translation>{0} no arranca: {1}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/source_messages.py" line="66"/>
        <source>reconnecting since {0}: {1}</source>
        <translation>reconectando desde las {0}: {1}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/source_messages.py" line="77"/>
        <source>back after {0} s</source>
        <translation>de vuelta tras {0} s</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/source_messages.py" line="94"/>
        <source>read only: {0}; values follow here but cannot be changed</source>
        <translation>solo lectura: {0}; los valores se siguen aquí, pero no se pueden cambiar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/source_messages.py" line="97"/>
        <source>Take control</source>
        <translation>Tomar el control</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/source_messages.py" line="102"/>
        <source>this window has control now: values can be changed</source>
        <translation>esta ventana tiene ahora el control: los valores se pueden cambiar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/source_messages.py" line="96"/>
        <source>control was not given: {0}; still read only</source>
        <translation>no se cedió el control: {0}; sigue solo de lectura</translation>
    </message>
</context>
<context>
    <name>CoverageView</name>
    <message>
        <location filename="../../grabbergui/ui/widgets/detections.py" line="137"/>
        <source>Tilts</source>
        <translation>Inclinaciones</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/widgets/detections.py" line="139"/>
        <source>Distances</source>
        <translation>Distancias</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/widgets/detections.py" line="145"/>
        <source>far</source>
        <translation>lejos</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/widgets/detections.py" line="145"/>
        <source>between</source>
        <translation>en medio</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/widgets/detections.py" line="145"/>
        <source>near</source>
        <translation>cerca</translation>
    </message>
</context>
<context>
    <name>CurveRow</name>
    <message>
        <location filename="../../grabbergui/ui/forms/curve_row.ui" line="35"/>
        <source>Remove this curve</source>
        <translation>Quitar esta curva</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/widgets/curve_row.py" line="44"/>
        <source>{0} over time</source>
        <translation>{0} en el tiempo</translation>
    </message>
</context>
<context>
    <name>Diagnosis</name>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="236"/>
        <source>Frames arrive but cannot be shown: {0}</source>
        <translation>Llegan imágenes pero no se pueden mostrar: {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="236"/>
        <source>Choose another PixelFormat; a snapshot still saves the raw bytes.</source>
        <translation>Elija otro PixelFormat; una captura guarda de todos modos los bytes en bruto.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="245"/>
        <source>Frames arrive but the window does not paint them.</source>
        <translation>Llegan imágenes pero la ventana no las dibuja.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="245"/>
        <source>See the log.</source>
        <translation>Vea el registro.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="272"/>
        <source>Check the cable and the camera&apos;s power; then stop and start again.</source>
        <translation>Compruebe el cable y la alimentación de la cámara; luego pare e inicie de nuevo.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="285"/>
        <source> (GevSCPSPacketSize, now {0} bytes)</source>
        <translation> (GevSCPSPacketSize, ahora {0} bytes)</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="287"/>
        <source>Packets arrive, but no frame is complete: {0} packets are missing.</source>
        <translation>Llegan paquetes, pero ninguna imagen está completa: faltan {0} paquetes.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="300"/>
        <source>{0} packets arrived, but no frame was finished.</source>
        <translation>Llegaron {0} paquetes, pero no se completó ninguna imagen.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="333"/>
        <source>{0} is under control but sends nothing that arrives here.</source>
        <translation>{0} está bajo control pero no envía nada que llegue aquí.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="340"/>
        <source>Stop and start again; check the camera&apos;s cable and power.</source>
        <translation>Pare e inicie de nuevo; compruebe el cable y la alimentación de la cámara.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="342"/>
        <source>UDP port {0}</source>
        <translation>el puerto UDP {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="344"/>
        <source>from the camera</source>
        <translation>desde la cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="347"/>
        <source>from {0}</source>
        <translation>desde {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="351"/>
        <source> Packets of {0} bytes need an MTU as large on every device between.</source>
        <translation> Los paquetes de {0} bytes necesitan una MTU igual de grande en cada dispositivo intermedio.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="353"/>
        <source>A firewall may drop it: let {0} {1} pass{2}.{3}</source>
        <translation>Un cortafuegos puede descartarlo: deje pasar {0} {1}{2}.{3}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="287"/>
        <source>Packets arrive, but no frame is complete: 1 packet is missing.</source>
        <translation>Llegan paquetes, pero ninguna imagen está completa: falta 1 paquete.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="300"/>
        <source>1 packet arrived, but no frame was finished.</source>
        <translation>Llegó 1 paquete, pero no se completó ninguna imagen.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="272"/>
        <source>No frame for {1:.0f} s, after 1 frame.</source>
        <translation>Ninguna imagen desde hace {1:.0f} s, tras una que llegó.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="272"/>
        <source>No frame for {1:.0f} s, after {0} frames.</source>
        <translation>Ninguna imagen desde hace {1:.0f} s, tras {0} que llegaron.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="287"/>
        <source>Choose smaller packets{0} or a longer packet delay (GevSCPD); raise net.core.rmem_max.</source>
        <translation>Elija paquetes más pequeños{0} o un retardo mayor entre paquetes (GevSCPD); aumente net.core.rmem_max.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="300"/>
        <source>The frame rate may be very low, or packets larger than the network&apos;s MTU are dropped.</source>
        <translation>La frecuencia puede ser muy baja, o se descartan los paquetes mayores que la MTU de la red.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="175"/>
        <source>an input</source>
        <translation>una entrada</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="318"/>
        <source>The recorded image is black.</source>
        <translation>La imagen grabada es negra.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="319"/>
        <source>The image is black.</source>
        <translation>La imagen es negra.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="321"/>
        <source>The image is black: the exposure ({0}) may be too short.</source>
        <translation>La imagen es negra: la exposición ({0}) puede ser demasiado corta.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="323"/>
        <source>Open the iris, or take the lens cap off.</source>
        <translation>Abra el iris o quite la tapa del objetivo.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="325"/>
        <source>Raise exposure or gain, or press E.</source>
        <translation>Aumente la exposición o la ganancia, o pulse E.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="326"/>
        <source>Raise the exposure, or press E.</source>
        <translation>Aumente la exposición o pulse E.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="327"/>
        <source>Raise the gain, or press E.</source>
        <translation>Aumente la ganancia o pulse E.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="263"/>
        <source>See whether its program sends images, and whether a camera there waits for a trigger.</source>
        <translation>Compruebe si su programa envía imágenes y si una cámara de allí espera un disparo.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="259"/>
        <source>Packets arrive, but no frame can be made of them.</source>
        <translation>Llegan paquetes, pero no se puede formar ningún fotograma con ellos.</translation>
    </message>
</context>
<context>
    <name>DoctorDialog</name>
    <message>
        <location filename="../../grabbergui/ui/forms/doctor_dialog.ui" line="6"/>
        <source>Doctor</source>
        <translation>Diagnóstico</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/doctor_dialog.ui" line="11"/>
        <source>Findings</source>
        <translation>Resultados</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/doctor_dialog.py" line="102"/>
        <source>Checking this computer…</source>
        <translation>Revisando este equipo…</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/doctor_dialog.py" line="135"/>
        <source>Nothing is wrong</source>
        <translation>No hay ningún problema</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/doctor_dialog.ui" line="24"/>
        <source>Check &amp;again</source>
        <translation>Comprobar de &amp;nuevo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/doctor_dialog.ui" line="26"/>
        <source>Copy all findings and remedies as text</source>
        <translation>Copiar todos los resultados y remedios como texto</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/doctor_dialog.ui" line="26"/>
        <source>&amp;Copy</source>
        <translation>&amp;Copiar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/doctor_dialog.ui" line="27"/>
        <source>Close</source>
        <translation>Cerrar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/doctor_dialog.py" line="80"/>
        <source>OK</source>
        <translation>Bien</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/doctor_dialog.py" line="81"/>
        <source>Warning</source>
        <translation>Aviso</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/doctor_dialog.py" line="82"/>
        <source>Fault</source>
        <translation>Fallo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/doctor_dialog.py" line="118"/>
        <source>Applying the remedy: {0}</source>
        <translation>Aplicando el remedio: {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/doctor_dialog.py" line="132"/>
        <source>1 fault</source>
        <translation>1 fallo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/doctor_dialog.py" line="132"/>
        <source>{0} faults</source>
        <translation>{0} fallos</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/doctor_dialog.py" line="133"/>
        <source>1 warning</source>
        <translation>1 aviso</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/doctor_dialog.py" line="133"/>
        <source>{0} warnings</source>
        <translation>{0} avisos</translation>
    </message>
</context>
<context>
    <name>DoctorRow</name>
    <message>
        <location filename="../../grabbergui/ui/forms/doctor_row.ui" line="27"/>
        <source>Do it</source>
        <translation>Hacerlo</translation>
    </message>
</context>
<context>
    <name>Drivers</name>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>the camera is lost: {0}</source>
        <translation>se perdió la cámara: {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>another application, at {0}, took control of the camera</source>
        <translation>otra aplicación, en {0}, tomó el control de la cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>the camera took our control back; its heartbeat may have expired, or it has restarted</source>
        <translation>la cámara retiró el control; puede que expirase su heartbeat o que se haya reiniciado</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>{0} was lost while it was opened</source>
        <translation>{0} se perdió mientras se abría</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>{0} is not open</source>
        <translation>{0} no está abierta</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>{0} was unplugged</source>
        <translation>{0} se desconectó</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>{0} was not acknowledged within {1} s ({2} tries)</source>
        <translation>{0} no se confirmó en {1} s (intentos: {2})</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>{0} was not acknowledged within {1} s; the camera had asked for more time</source>
        <translation>{0} no se confirmó en {1} s; la cámara había pedido más tiempo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>{0} did not answer in time</source>
        <translation>{0} no respondió a tiempo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>{0} did not answer within {1} s</source>
        <translation>{0} no respondió en {1} s</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>the device takes no commands; unplug it and plug it in again</source>
        <translation>el dispositivo no acepta órdenes; desconéctelo y vuelva a conectarlo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>another application at {0} controls {1}; close it there</source>
        <translation>otra aplicación en {0} controla {1}; ciérrela allí</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>another application controls {0}; close it there</source>
        <translation>otra aplicación controla {0}; ciérrela allí</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>{0} is in use by another application; close it there</source>
        <translation>otra aplicación usa {0}; ciérrela allí</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>the camera is open for reading only; another application may control it</source>
        <translation>la cámara está abierta solo para lectura; puede que otra aplicación la controle</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>the camera answers reads but not this write; another application may control it</source>
        <translation>la cámara responde a las lecturas pero no a esta escritura; puede que otra aplicación la controle</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>the camera is served read-only</source>
        <translation>la cámara se sirve solo para lectura</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>{0} is not there any more</source>
        <translation>{0} ya no existe</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>{0} is {1} instead of {2}</source>
        <translation>{0} es {1} en lugar de {2}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>the camera did not answer for {0} s</source>
        <translation>la cámara no respondió durante {0} s</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/sentences.py" line="7"/>
        <source>the target is not seen: bring it into the middle of the image first</source>
        <translation>no se ve el objetivo: llévelo primero al centro de la imagen</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/sentences.py" line="7"/>
        <source>only {0} of {1} views were possible: give the arm more room, or move the target</source>
        <translation>solo fueron posibles {0} de {1} vistas: dé más espacio al brazo o mueva el objetivo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/sentences.py" line="7"/>
        <source>only {0} of {1} poses show the target, {2} are wanted: move it, or take a smaller one</source>
        <translation>solo {0} de {1} posturas muestran el objetivo y se quieren {2}: muévalo o use uno más pequeño</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/sentences.py" line="7"/>
        <source>hand–eye calibration needs {0} views or more, not {1}</source>
        <translation>la calibración mano-ojo necesita {0} vistas o más, no {1}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/sentences.py" line="7"/>
        <source>the views differ too little: turn camera or target about two axes between them</source>
        <translation>las vistas se diferencian muy poco: gire la cámara o el objetivo sobre dos ejes entre ellas</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/sentences.py" line="7"/>
        <source>the views contradict one another: check the target&apos;s size and the calibration</source>
        <translation>las vistas se contradicen: compruebe el tamaño del objetivo y la calibración</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/sentences.py" line="7"/>
        <source>no image arrived within {0} s: check camera and cable</source>
        <translation>no llegó ninguna imagen en {0} s: compruebe la cámara y el cable</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/sentences.py" line="7"/>
        <source>there is no camera to look with</source>
        <translation>no hay cámara con la que mirar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/sentences.py" line="7"/>
        <source>the robot is stopped: {0}</source>
        <translation>el robot está parado: {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/sentences.py" line="7"/>
        <source>{0} does not report its joints</source>
        <translation>{0} no comunica sus articulaciones</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/sentences.py" line="7"/>
        <source>{0} does not report the angles of its arm</source>
        <translation>{0} no comunica los ángulos de su brazo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/sentences.py" line="7"/>
        <source>{0} no longer reports the angles of its arm</source>
        <translation>{0} ya no comunica los ángulos de su brazo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/sentences.py" line="7"/>
        <source>the head of {0} is not driven</source>
        <translation>la cabeza de {0} no está accionada</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/sentences.py" line="7"/>
        <source>the arm of {0} is not driven</source>
        <translation>el brazo de {0} no está accionado</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/sentences.py" line="7"/>
        <source>this is a dry run, in which the robot does not move: start without --dry-run</source>
        <translation>esto es una prueba en la que el robot no se mueve: arranque sin --dry-run</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/sentences.py" line="7"/>
        <source>it would leave the workspace ({0} = {1} m)</source>
        <translation>saldría del espacio de trabajo ({0} = {1} m)</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/sentences.py" line="7"/>
        <source>it would leave the workspace ({0})</source>
        <translation>saldría del espacio de trabajo ({0})</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/sentences.py" line="7"/>
        <source>{0} would come within {1} mm of {2}</source>
        <translation>{0} se acercaría a {1} mm de {2}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>a pitch of {0} m must be more than the markers&apos; size, {1} m, or they would overlap</source>
        <translation>un paso de {0} m debe ser mayor que el tamaño de los marcadores, {1} m, o se solaparían</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>two poses explain it</source>
        <translation>dos posturas lo explican</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>it is seen edge-on</source>
        <translation>se ve de canto</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>its corners are no square&apos;s</source>
        <translation>sus esquinas no son las de un cuadrado</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>this program controls {0} already; close it first</source>
        <translation>este programa ya controla {0}; ciérrela primero</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>another application took exclusive control of the camera</source>
        <translation>otra aplicación tomó el control exclusivo de la cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>another application has exclusive control of the camera at {0}; close it there</source>
        <translation>otra aplicación tiene el control exclusivo de la cámara en {0}; ciérrela allí</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>{0}: its USB bus has too little bandwidth left; choose a smaller size, MJPG or a lower rate, or plug it in elsewhere</source>
        <translation>{0}: a su bus USB le queda poco ancho de banda; elija un tamaño menor, MJPG o una frecuencia más baja, o conéctela en otro puerto</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>{0} is set to {1}, which cannot be shown; choose another PixelFormat</source>
        <translation>{0} está en {1}, que no se puede mostrar; elija otro PixelFormat</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>{0} is there already; a recording overwrites nothing, choose another name</source>
        <translation>{0} ya existe; una grabación no sobrescribe nada, elija otro nombre</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>{0} could not be created: {1}; choose another folder or name</source>
        <translation>no se pudo crear {0}: {1}; elija otra carpeta u otro nombre</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>the snapshot could not be written to {0}: {1}; choose another folder</source>
        <translation>no se pudo guardar la captura en {0}: {1}; elija otra carpeta</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>{0} could not be written: {1}</source>
        <translation>no se pudo escribir {0}: {1}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>{0} could not be read: {1}</source>
        <translation>no se pudo leer {0}: {1}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>&apos;{0}&apos; is no source; did you mean {1}?</source>
        <translation>«{0}» no es una fuente; ¿quería decir {1}?</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>&apos;{0}&apos; is no source; write its kind first, as in sim: or gige:192.168.0.10</source>
        <translation>«{0}» no es una fuente; escriba antes su tipo, como en sim: o gige:192.168.0.10</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>&apos;{0}&apos; is of no known kind; there are {1}</source>
        <translation>«{0}» es de un tipo desconocido; existen {1}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>{0} is not connected to this program at the moment</source>
        <translation>{0} no está conectado a este programa en este momento</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>{0} sends messages that are no images ({1})</source>
        <translation>{0} envía mensajes que no son imágenes ({1})</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>{0} is connected over {1} and sends nothing</source>
        <translation>{0} está conectado por {1} y no envía nada</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>{0} is subscribed to, and {1} sends nothing that arrives here</source>
        <translation>{0} está suscrito y {1} no envía nada que llegue aquí</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>nobody publishes {0}</source>
        <translation>nadie publica {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>the camera sees this computer at {0}, not at {1}: a router between them translates addresses (NAT), so frames do not get through; give this computer an address in the camera&apos;s network</source>
        <translation>la cámara ve este ordenador en {0}, no en {1}: un router intermedio traduce direcciones (NAT), así que los fotogramas no llegan; dé a este ordenador una dirección en la red de la cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>no packet arrives; {0} and {1} are in one subnet, {2}; the system may use the wrong one for a camera: give {3} and its cameras addresses of another subnet</source>
        <translation>no llega ningún paquete; {0} y {1} están en la misma subred, {2}; el sistema puede usar la equivocada para una cámara: dé a {3} y a sus cámaras direcciones de otra subred</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>no packet arrives; a firewall may drop them: {0}</source>
        <translation>no llega ningún paquete; un cortafuegos puede descartarlos: {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>there is no edge on {0}, it is always low: check the cable, LineMode and the sender</source>
        <translation>no hay ningún flanco en {0}, siempre está en bajo: compruebe el cable, LineMode y el emisor</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>there is no edge on {0}, it is always high: check the cable, LineMode and the sender</source>
        <translation>no hay ningún flanco en {0}, siempre está en alto: compruebe el cable, LineMode y el emisor</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>there is no edge on {0}: check the cable, LineMode and the sender</source>
        <translation>no hay ningún flanco en {0}: compruebe el cable, LineMode y el emisor</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>no trigger arrives on {0}; it is low</source>
        <translation>no llega ningún disparo a {0}; está en bajo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>no trigger arrives on {0}; it is high</source>
        <translation>no llega ningún disparo a {0}; está en alto</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>no trigger arrives on {0}</source>
        <translation>no llega ningún disparo a {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>{0} has only edges of the other kind; set TriggerActivation to {1}, or switch LineInverter</source>
        <translation>{0} solo tiene flancos del otro tipo; ponga TriggerActivation en {1} o cambie LineInverter</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>the camera triggers at the end of each pulse, {0} µs late; set TriggerActivation to {1}, or switch LineInverter</source>
        <translation>la cámara dispara al final de cada pulso, {0} µs tarde; ponga TriggerActivation en {1} o cambie LineInverter</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>pulses missing between the others: {0}; the sender or the cable drops some</source>
        <translation>pulsos que faltan entre los demás: {0}; el emisor o el cable pierde algunos</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>triggers come at {0} Hz, but exposure and readout allow {1} Hz; {2} were missed (without overlap of exposure and readout; with it {3} Hz)</source>
        <translation>los disparos llegan a {0} Hz, pero exposición y lectura permiten {1} Hz; se perdieron {2} (sin solapar exposición y lectura; con solape, {3} Hz)</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>triggers come at {0} Hz, but exposure and readout allow {1} Hz; {2} were missed</source>
        <translation>los disparos llegan a {0} Hz, pero exposición y lectura permiten {1} Hz; se perdieron {2}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>a trigger makes {0} frames instead of {1}; each frame waits for a trigger of its own: set TriggerMode[TriggerSelector=FrameStart] to Off</source>
        <translation>un disparo produce {0} imágenes en vez de {1}; cada una espera su propio disparo: ponga TriggerMode[TriggerSelector=FrameStart] en Off</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>a trigger makes {0} frames instead of {1}; the acquisition ends before: check AcquisitionMode and AcquisitionFrameCount</source>
        <translation>un disparo produce {0} imágenes en vez de {1}; la adquisición termina antes: compruebe AcquisitionMode y AcquisitionFrameCount</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>the camera ignores the actions: {0}</source>
        <translation>la cámara ignora las acciones: {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>edges within {0} µs of another: {1}; a contact bounces: use a debouncer (LineDebouncerTime) or a clean signal</source>
        <translation>flancos a menos de {0} µs de otro: {1}; un contacto rebota: use LineDebouncerTime o una señal limpia</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>double pulses, {0} ms apart: {1}; are there two senders on the line?</source>
        <translation>pulsos dobles, separados {0} ms: {1}; ¿hay dos emisores en la línea?</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>frames that were lost on the wire: {0}; every trigger was taken: plan the link&apos;s budget</source>
        <translation>imágenes perdidas en la red: {0}; se aceptaron todos los disparos: planifique el presupuesto del enlace</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/language.py" line="68"/>
        <source>actions that did not reach the camera: {0} of {1}; they were lost on the network</source>
        <translation>acciones que no llegaron a la cámara: {0} de {1}; se perdieron en la red</translation>
    </message>
</context>
<context>
    <name>Errors</name>
    <message>
        <location filename="../../grabbergui/models/error_text.py" line="53"/>
        <source>the connection to {0} was lost</source>
        <translation>se perdió la conexión con {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/error_text.py" line="82"/>
        <source>another application controls it</source>
        <translation>otra aplicación la controla</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/error_text.py" line="93"/>
        <source>the camera has no {0}</source>
        <translation>la cámara no tiene {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/error_text.py" line="97"/>
        <source>{0} does not take this value; allowed: {1}</source>
        <translation>{0} no admite este valor; se permite: {1}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/error_text.py" line="99"/>
        <source>{0} was refused: {1}</source>
        <translation>la cámara rechazó {0}: {1}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/error_text.py" line="108"/>
        <source>{0} was not found; check address, power and cable</source>
        <translation>no se encuentra {0}; compruebe dirección, alimentación y cable</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/error_text.py" line="110"/>
        <source>{0} does not answer; check address, power and cable</source>
        <translation>{0} no responde; compruebe dirección, alimentación y cable</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/error_text.py" line="112"/>
        <source>no access to {0}: {1}</source>
        <translation>no hay acceso a {0}: {1}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/error_text.py" line="114"/>
        <source>{0} cannot be used on this computer: {1}</source>
        <translation>{0} no se puede usar en este equipo: {1}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/error_text.py" line="120"/>
        <source>the camera does not answer: {0}</source>
        <translation>la cámara no responde: {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/error_text.py" line="120"/>
        <source>the connection to the camera was lost: {0}</source>
        <translation>se perdió la conexión con la cámara: {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/error_text.py" line="120"/>
        <source>the camera cannot be reached: {0}</source>
        <translation>no se llega a la cámara: {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/error_text.py" line="120"/>
        <source>the camera refused it: {0}</source>
        <translation>la cámara lo rechazó: {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/error_text.py" line="120"/>
        <source>access denied: {0}</source>
        <translation>acceso denegado: {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/error_text.py" line="120"/>
        <source>not found: {0}</source>
        <translation>no encontrado: {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/error_text.py" line="120"/>
        <source>this cannot be understood: {0}</source>
        <translation>no se entiende: {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/error_text.py" line="105"/>
        <source>{0} may be another camera than the one you named: {1}</source>
        <translation>{0} puede no ser la cámara que indicó: {1}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/error_text.py" line="74"/>
        <source>; and {0} more</source>
        <translation>; y {0} más</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/error_text.py" line="63"/>
        <source>set as before</source>
        <translation>ajustada como antes</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/error_text.py" line="65"/>
        <source>but not as before: {0}</source>
        <translation>pero no como antes: {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/error_text.py" line="67"/>
        <source>; changed meanwhile, not by us: {0}</source>
        <translation>; cambiado entretanto, no por nosotros: {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/error_text.py" line="87"/>
        <source>no other application controls it any more</source>
        <translation>ninguna otra aplicación la controla ya</translation>
    </message>
</context>
<context>
    <name>FavouritesController</name>
    <message>
        <location filename="../../grabbergui/ui/controllers/features.py" line="208"/>
        <source>no more than {0} controls can be pinned; unpin one first</source>
        <translation>no puede haber más de {0} controles fijados; suelte uno antes</translation>
    </message>
</context>
<context>
    <name>FavouritesStrip</name>
    <message>
        <location filename="../../grabbergui/ui/forms/favourites.ui" line="7"/>
        <source>Favourites</source>
        <translation>Favoritos</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/favourites.ui" line="17"/>
        <source>Exposure, gain and frame rate appear here if the camera has them.</source>
        <translation>Aquí aparecen exposición, ganancia y frecuencia, si la cámara las tiene.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/favourites.py" line="75"/>
        <source>Drag the name of a feature here to pin it above the image.</source>
        <translation>Arrastre aquí el nombre de un parámetro para fijarlo sobre la imagen.</translation>
    </message>
</context>
<context>
    <name>FeatureController</name>
    <message>
        <location filename="../../grabbergui/ui/controllers/features.py" line="131"/>
        <source>Exposure</source>
        <translation>Exposición</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/features.py" line="132"/>
        <source>Gain</source>
        <translation>Ganancia</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/features.py" line="133"/>
        <source>Frame rate</source>
        <translation>Frecuencia</translation>
    </message>
</context>
<context>
    <name>FeatureMenuController</name>
    <message>
        <location filename="../../grabbergui/ui/controllers/features.py" line="272"/>
        <source>&amp;Plot over time</source>
        <translation>&amp;Representar en el tiempo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/features.py" line="275"/>
        <source>&amp;Copy the name</source>
        <translation>&amp;Copiar el nombre</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/features.py" line="279"/>
        <source>Copy name and &amp;value</source>
        <translation>Copiar nombre y &amp;valor</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/features.py" line="287"/>
        <source>P&amp;in</source>
        <translation>F&amp;ijar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/features.py" line="291"/>
        <source>&amp;Unpin</source>
        <translation>&amp;Soltar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/features.py" line="293"/>
        <source>Move to the &amp;left</source>
        <translation>Mover a la &amp;izquierda</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/features.py" line="293"/>
        <source>Move to the ri&amp;ght</source>
        <translation>Mover a la &amp;derecha</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/features.py" line="300"/>
        <source>Pin t&amp;he usual controls</source>
        <translation>Fijar los controles &amp;habituales</translation>
    </message>
</context>
<context>
    <name>FeaturePanel</name>
    <message>
        <location filename="../../grabbergui/ui/forms/feature_panel.ui" line="20"/>
        <source>Features</source>
        <translation>Parámetros</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/feature_panel.ui" line="43"/>
        <source>Show the features whose name or description contains these words</source>
        <translation>Mostrar los parámetros cuyo nombre o descripción contiene estas palabras</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/feature_panel.ui" line="46"/>
        <source>Filter features</source>
        <translation>Filtrar parámetros</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/feature_panel.ui" line="49"/>
        <source>Filter features…</source>
        <translation>Filtrar parámetros…</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/feature_panel.ui" line="59"/>
        <source>How many features to show</source>
        <translation>Cuántos parámetros mostrar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/feature_panel.ui" line="62"/>
        <source>Visibility</source>
        <translation>Nivel</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/feature_panel.ui" line="66"/>
        <source>Beginner</source>
        <translation>Básico</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/feature_panel.ui" line="71"/>
        <source>Expert</source>
        <translation>Experto</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/feature_panel.ui" line="76"/>
        <source>Guru</source>
        <translation>Gurú</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/feature_panel.py" line="328"/>
        <source>The camera&apos;s controls appear here once one is connected.</source>
        <translation>Los controles de la cámara aparecen aquí cuando se conecta una.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/feature_panel.py" line="353"/>
        <source>{0} more match; type another letter.</source>
        <translation>Coinciden {0} más; escriba otra letra.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/feature_panel.py" line="358"/>
        <source>Nothing matches.</source>
        <translation>No hay coincidencias.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/feature_panel.py" line="353"/>
        <source>1 more matches; type another letter.</source>
        <translation>Coincide 1 más; escriba otra letra.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/feature_panel.ui" line="147"/>
        <source>Show the features of every visibility</source>
        <translation>Mostrar las características de cualquier visibilidad</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/feature_panel.py" line="338"/>
        <source>Show {0} more (Guru)</source>
        <translation>Mostrar {0} más (Guru)</translation>
    </message>
</context>
<context>
    <name>Features</name>
    <message>
        <location filename="../../grabbergui/models/features/feature_text.py" line="38"/>
        <source>is not available: {0}</source>
        <translation>no está disponible: {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/features/feature_text.py" line="42"/>
        <source>is not implemented by this camera</source>
        <translation>no existe en esta cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/features/feature_text.py" line="44"/>
        <source>is not available at the moment; another feature&apos;s value hides it</source>
        <translation>no está disponible ahora; lo oculta el valor de otro parámetro</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/features/feature_text.py" line="46"/>
        <source>is read-only; streaming or another feature may lock it</source>
        <translation>es de solo lectura; puede bloquearlo la captura u otro parámetro</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/features/feature_text.py" line="47"/>
        <source>cannot be used at the moment</source>
        <translation>no se puede usar ahora</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/features/feature_text.py" line="54"/>
        <source>one of {0}</source>
        <translation>uno de {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/features/feature_text.py" line="56"/>
        <source>true or false</source>
        <translation>sí o no</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/features/feature_text.py" line="59"/>
        <source>up to {0} bytes of text</source>
        <translation>texto de hasta {0} bytes</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/features/feature_text.py" line="64"/>
        <source>text</source>
        <translation>texto</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/features/feature_text.py" line="66"/>
        <source>a number</source>
        <translation>un número</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/features/feature_text.py" line="70"/>
        <source>{0}, step {1}</source>
        <translation>{0}, paso {1}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/features/feature_text.py" line="93"/>
        <source>yes</source>
        <translation>sí</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/features/feature_text.py" line="93"/>
        <source>no</source>
        <translation>no</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/features/feature_text.py" line="106"/>
        <source>It {0}.</source>
        <translation>Este parámetro {0}.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/features/feature_text.py" line="114"/>
        <source>Value: {0}</source>
        <translation>Valor: {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/features/feature_text.py" line="115"/>
        <source>Range: {0}</source>
        <translation>Rango: {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/features/feature_text.py" line="117"/>
        <source>Selected by: {0}</source>
        <translation>Selector: {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/features/feature_text.py" line="109"/>
        <source>Changing it pauses the stream for a moment.</source>
        <translation>Cambiarlo detiene la captura un momento.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/features/feature_text.py" line="40"/>
        <source>is read-only</source>
        <translation>es de solo lectura</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/features/feature_text.py" line="59"/>
        <source>1 byte of text</source>
        <translation>texto de 1 byte</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/features/feature_text.py" line="79"/>
        <source>At least {0}</source>
        <translation>Como mínimo {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/features/feature_text.py" line="81"/>
        <source>At most {0}</source>
        <translation>Como máximo {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/features/feature_text.py" line="83"/>
        <source>Only in steps of {0}</source>
        <translation>Solo en pasos de {0}</translation>
    </message>
</context>
<context>
    <name>FocusPanel</name>
    <message>
        <location filename="../../grabbergui/ui/forms/focus_panel.ui" line="17"/>
        <source>Sharpness</source>
        <translation>Nitidez</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/focus_panel.ui" line="37"/>
        <source>Draw the region to bring into focus</source>
        <translation>Dibujar la región que debe ser nítida</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/focus_panel.ui" line="38"/>
        <source>Choose region</source>
        <translation>Elegir región</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/focus_panel.ui" line="43"/>
        <source>Score the whole image</source>
        <translation>Valorar toda la imagen</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/focus_panel.ui" line="44"/>
        <source>Whole image</source>
        <translation>Toda la imagen</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/focus_panel.ui" line="49"/>
        <source>Forget the best score</source>
        <translation>Olvidar el mejor valor</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/focus_panel.ui" line="50"/>
        <source>Start again</source>
        <translation>Empezar de nuevo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/focus_panel.ui" line="23"/>
        <source>Sharpness over time</source>
        <translation>Nitidez en el tiempo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/measuring_panels.py" line="216"/>
        <source>Sharpness over the last seconds; dashed: the best</source>
        <translation>Nitidez en los últimos segundos; línea discontinua: la mejor</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/measuring_panels.py" line="203"/>
        <source>of the whole image</source>
        <translation>de toda la imagen</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/measuring_panels.py" line="190"/>
        <source>Sharpness {0:.2f}    best {1:.2f}    {2:.0%} of the best</source>
        <translation>Nitidez {0:.2f}    mejor {1:.2f}    {2:.0%} de la mejor</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/measuring_panels.py" line="190"/>
        <source>Sharpness {0:.2f}    best {1:.2f}</source>
        <translation>Nitidez {0:.2f}    mejor {1:.2f}</translation>
    </message>
</context>
<context>
    <name>FrameData</name>
    <message>
        <location filename="../../grabbergui/models/image/frame_data.py" line="19"/>
        <source>Frame id</source>
        <translation>Id. del fotograma</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/image/frame_data.py" line="20"/>
        <source>Exposed or received at</source>
        <translation>Expuesto o recibido a las</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/image/frame_data.py" line="21"/>
        <source>Camera&apos;s clock</source>
        <translation>Reloj de la cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/image/frame_data.py" line="22"/>
        <source>Size</source>
        <translation>Tamaño</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/image/frame_data.py" line="23"/>
        <source>Pixel format</source>
        <translation>Formato de píxel</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/image/frame_data.py" line="24"/>
        <source>Offset</source>
        <translation>Desplazamiento</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/image/frame_data.py" line="25"/>
        <source>Payload</source>
        <translation>Datos</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/image/frame_data.py" line="36"/>
        <source>{0} bytes</source>
        <translation>{0} bytes</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/image/frame_data.py" line="26"/>
        <source>Completeness</source>
        <translation>Integridad</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/image/frame_data.py" line="29"/>
        <source>Stream channel</source>
        <translation>Canal de flujo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/image/frame_data.py" line="31"/>
        <source>File</source>
        <translation>Archivo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/image/frame_data.py" line="53"/>
        <source>complete</source>
        <translation>completo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/image/frame_data.py" line="54"/>
        <source>1 byte is missing</source>
        <translation>falta 1 byte</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/image/frame_data.py" line="54"/>
        <source>{0} bytes are missing</source>
        <translation>faltan {0} bytes</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/image/frame_data.py" line="36"/>
        <source>1 byte</source>
        <translation>1 byte</translation>
    </message>
</context>
<context>
    <name>FrameDataDialog</name>
    <message>
        <location filename="../../grabbergui/ui/forms/frame_data.ui" line="6"/>
        <source>Data of the shown frame</source>
        <translation>Datos del fotograma mostrado</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/frame_data.ui" line="10"/>
        <source>Data of the frame</source>
        <translation>Datos del fotograma</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/frame_data.ui" line="13"/>
        <source>Name</source>
        <translation>Nombre</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/frame_data.ui" line="14"/>
        <source>Value</source>
        <translation>Valor</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/frame_data.ui" line="19"/>
        <source>Chunk data appears here once ChunkModeActive and the chunks are on.</source>
        <translation>Los datos de chunk aparecen aquí cuando ChunkModeActive y los chunks están activados.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/frame_data.ui" line="27"/>
        <source>&amp;Copy</source>
        <translation>&amp;Copiar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/frame_data.ui" line="28"/>
        <source>Close</source>
        <translation>Cerrar</translation>
    </message>
</context>
<context>
    <name>FramesToRecordController</name>
    <message>
        <location filename="../../grabbergui/ui/controllers/frames_to_record.py" line="28"/>
        <source>&amp;All frames</source>
        <translation>&amp;Todas las imágenes</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/frames_to_record.py" line="29"/>
        <source>&amp;Every n-th frame…</source>
        <translation>&amp;Una de cada n…</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/frames_to_record.py" line="30"/>
        <source>&amp;Time-lapse…</source>
        <translation>&amp;Cámara rápida…</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/frames_to_record.py" line="40"/>
        <source>Record one of so many frames:</source>
        <translation>Grabar una de cada tantas imágenes:</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/frames_to_record.py" line="48"/>
        <source>Record a frame every so many seconds:</source>
        <translation>Grabar una imagen cada tantos segundos:</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/frames_to_record.py" line="59"/>
        <source>Frames to record</source>
        <translation>Imágenes que grabar</translation>
    </message>
</context>
<context>
    <name>Gallery</name>
    <message>
        <location filename="../../grabbergui/ui/forms/gallery.ui" line="6"/>
        <source>Open sources</source>
        <translation>Fuentes abiertas</translation>
    </message>
</context>
<context>
    <name>HandEye</name>
    <message>
        <location filename="../../grabbergui/servo/models/hand_eye.py" line="214"/>
        <source>the result could not be saved as {0}: {1}</source>
        <translation>no se pudo guardar el resultado como {0}: {1}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/hand_eye.py" line="370"/>
        <source>Stopped</source>
        <translation>Parado</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/hand_eye.py" line="345"/>
        <source>the target is not seen</source>
        <translation>no se ve el objetivo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/hand_eye.py" line="357"/>
        <source>no images arrive from the camera</source>
        <translation>no llegan imágenes de la cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/hand_eye.py" line="374"/>
        <source>internal error, see the log: {0}</source>
        <translation>error interno, véase el registro: {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/hand_eye_text.py" line="20"/>
        <source>&lt;b&gt;{0} will move by itself&lt;/b&gt; to {1} poses, one after another, for {2}.</source>
        <translation>&lt;b&gt;{0} se moverá por sí mismo&lt;/b&gt; a {1} posturas, una tras otra, durante {2}.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/hand_eye_text.py" line="24"/>
        <source>The head turns at up to {0:.0f} °/s; the arm rests.</source>
        <translation>La cabeza gira a un máximo de {0:.0f} °/s; el brazo reposa.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/hand_eye_text.py" line="26"/>
        <source>Pan stays within {0}° to {1}°, tilt within {2}° to {3}°.</source>
        <translation>El giro queda entre {0}° y {1}°, la inclinación entre {2}° y {3}°.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/hand_eye_text.py" line="30"/>
        <source>The hand moves at up to {0:.0f} mm/s, first by {1} small moves of at most {2:.0f}°.</source>
        <translation>La mano se mueve a un máximo de {0:.0f} mm/s, primero con {1} movimientos pequeños de {2:.0f}° como mucho.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/hand_eye_text.py" line="34"/>
        <source>Each joint stays within {0:.0f}° of where it is now.</source>
        <translation>Cada articulación queda a menos de {0:.0f}° de donde está ahora.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/hand_eye_text.py" line="36"/>
        <source>The hand stays within x {0} to {1}, y {2} to {3}, z {4} to {5} m in the base.</source>
        <translation>La mano queda entre x {0} y {1}, y {2} y {3}, z {4} y {5} m en la base.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/hand_eye_text.py" line="41"/>
        <source>The robot&apos;s body is not known: only the workspace is checked.</source>
        <translation>No se conoce el cuerpo del robot: solo se comprueba el espacio de trabajo.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/hand_eye_text.py" line="43"/>
        <source>The arm keeps {0:.0f} mm away from body and configured obstacles.</source>
        <translation>El brazo se mantiene a {0:.0f} mm del cuerpo y de los obstáculos configurados.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/hand_eye_text.py" line="46"/>
        <source>&lt;b&gt;The camera is not calibrated&lt;/b&gt;: calibrate it first, or the result is rough.</source>
        <translation>&lt;b&gt;La cámara no está calibrada&lt;/b&gt;: calíbrela primero, o el resultado será aproximado.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/hand_eye_text.py" line="50"/>
        <source>Space, Escape and the stop button stop it at once, from any of its windows.</source>
        <translation>Espacio, Escape y el botón de parada lo paran de inmediato, desde cualquiera de sus ventanas.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/hand_eye_text.py" line="59"/>
        <source>about {0} s</source>
        <translation>aprox. {0} s</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/hand_eye_text.py" line="60"/>
        <source>about {0} min</source>
        <translation>aprox. {0} min</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/hand_eye_text.py" line="66"/>
        <source>moving to pose {0}</source>
        <translation>yendo a la postura {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/hand_eye_text.py" line="68"/>
        <source>pose {0} taken</source>
        <translation>postura {0} tomada</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/hand_eye_text.py" line="70"/>
        <source>computing the result</source>
        <translation>calculando el resultado</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/hand_eye_text.py" line="73"/>
        <source>known to {0:.1f} mm and {1:.2f}°</source>
        <translation>conocida a {0:.1f} mm y {1:.2f}°</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/hand_eye_text.py" line="76"/>
        <source>skipped: {0}</source>
        <translation>omitida: {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/hand_eye_text.py" line="83"/>
        <source>the gate refuses it</source>
        <translation>la compuerta de seguridad la rechaza</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/hand_eye_text.py" line="84"/>
        <source>it was not reached</source>
        <translation>no se alcanzó</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/hand_eye_text.py" line="85"/>
        <source>the target is not seen reliably</source>
        <translation>el objetivo no se ve con seguridad</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/hand_eye_text.py" line="86"/>
        <source>the robot did not come to rest</source>
        <translation>el robot no estaba en reposo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/hand_eye_text.py" line="93"/>
        <source>{0}. The robot stands still. {1} poses were taken: compute from them, or start again</source>
        <translation>{0}. El robot está quieto. Se tomaron {1} posturas: calcule con ellas o empiece de nuevo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/hand_eye_text.py" line="115"/>
        <source>Known to</source>
        <translation>Conocida a</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/hand_eye_text.py" line="119"/>
        <source>x, y, z (mm)</source>
        <translation>x, y, z (mm)</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/hand_eye_text.py" line="120"/>
        <source>Roll, pitch, yaw (°)</source>
        <translation>Alabeo, cabeceo, guiñada (°)</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/hand_eye_text.py" line="121"/>
        <source>Residual</source>
        <translation>Residuo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/hand_eye_text.py" line="121"/>
        <source>{0:.3f} px over {1} of {2} poses</source>
        <translation>{0:.3f} px en {1} de {2} posturas</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/hand_eye_text.py" line="127"/>
        <source>Method</source>
        <translation>Método</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/hand_eye_text.py" line="127"/>
        <source>{0}, refined with all corners together</source>
        <translation>{0}, refinado con todas las esquinas a la vez</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/hand_eye_text.py" line="135"/>
        <source>Joint offsets</source>
        <translation>Desfases</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/hand_eye_text.py" line="142"/>
        <source>the calibration in use</source>
        <translation>la calibración en uso</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/hand_eye_text.py" line="143"/>
        <source>the robot&apos;s model, which is in use</source>
        <translation>el modelo del robot, que está en uso</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/hand_eye_text.py" line="145"/>
        <source>{0:.1f} mm and {1:.2f}° from {2}</source>
        <translation>{0:.1f} mm y {1:.2f}° de {2}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/hand_eye_text.py" line="97"/>
        <source>{0}. The robot stands still. Poses taken: {1}; needed: {2}. Start again</source>
        <translation>{0}. El robot está quieto. Posturas tomadas: {1}; necesarias: {2}. Empiece de nuevo</translation>
    </message>
</context>
<context>
    <name>HandEyeController</name>
    <message>
        <location filename="../../grabbergui/servo/ui/hand_eye_controller.py" line="135"/>
        <source>name both frames: what the camera is mounted on, and the camera&apos;s own</source>
        <translation>nombre ambos sistemas de referencia: el del soporte de la cámara y el de la cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/hand_eye_controller.py" line="143"/>
        <source>Save the robot&apos;s file</source>
        <translation>Guardar el archivo del robot</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/hand_eye_controller.py" line="162"/>
        <source>Servoing uses a camera on the head; save this result or publish it</source>
        <translation>El servocontrol usa una cámara en la cabeza; guarde este resultado o publíquelo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/hand_eye_controller.py" line="167"/>
        <source>Saved as {0}. Use it with `grabbergui servo … --hand-eye {0}`</source>
        <translation>Guardado como {0}. Úselo con `grabbergui servo … --hand-eye {0}`</translation>
    </message>
</context>
<context>
    <name>HandEyeDialog</name>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="6"/>
        <source>Calibrate hand and eye</source>
        <translation>Calibrar mano y ojo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="19"/>
        <source>EMERGENCY STOP</source>
        <translation>PARADA DE EMERGENCIA</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="20"/>
        <source>Stops the robot at once (Escape; Space while it moves)</source>
        <translation>Para el robot de inmediato (Escape; Espacio mientras se mueve)</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="35"/>
        <source>Live image</source>
        <translation>Imagen en directo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="45"/>
        <source>● waiting for an image</source>
        <translation>● esperando una imagen</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="76"/>
        <source>Camera on the &amp;head, board fixed</source>
        <translation>Cámara en la ca&amp;beza, tablero fijo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="76"/>
        <source>The head turns and looks at a fixed board</source>
        <translation>La cabeza gira y mira un tablero fijo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="77"/>
        <source>Camera on the h&amp;and, board fixed</source>
        <translation>Cámara en la &amp;mano, tablero fijo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="77"/>
        <source>The hand moves around a fixed board</source>
        <translation>La mano se mueve alrededor de un tablero fijo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="78"/>
        <source>Camera fixed, &amp;board in the hand</source>
        <translation>Cámara &amp;fija, tablero en la mano</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="78"/>
        <source>The camera is fixed; the hand moves the board in front of it</source>
        <translation>La cámara está fija; la mano mueve el tablero delante de ella</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="83"/>
        <source>B&amp;oard</source>
        <translation>&amp;Tablero</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="84"/>
        <source>One marker</source>
        <translation>Un marcador</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="84"/>
        <source>Grid of markers</source>
        <translation>Cuadrícula de marcadores</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="84"/>
        <source>ChArUco</source>
        <translation>ChArUco</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="85"/>
        <source>&amp;Dictionary</source>
        <translation>&amp;Diccionario</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="87"/>
        <source>N&amp;umber</source>
        <translation>&amp;Número</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="88"/>
        <source>The marker&apos;s number, or the first one on the board</source>
        <translation>El número del marcador, o el primero del tablero</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="89"/>
        <source>A&amp;cross, down</source>
        <translation>Anc&amp;ho, alto</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="90"/>
        <source>Markers of a grid, or squares of a ChArUco board, in a row</source>
        <translation>Marcadores de una cuadrícula, o casillas de un tablero ChArUco, a lo ancho</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="90"/>
        <source>Number of rows</source>
        <translation>Número de filas</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="90"/>
        <source>Down</source>
        <translation>Alto</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="91"/>
        <source>&amp;Marker, pitch</source>
        <translation>Ma&amp;rcador, paso</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="92"/>
        <source>Edge of a marker&apos;s black square, as measured on the paper</source>
        <translation>Lado del cuadrado negro de un marcador, medido en el papel</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="92"/>
        <source> mm</source>
        <translation> mm</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="92"/>
        <source>Distance between the markers of a grid; edge of a ChArUco square</source>
        <translation>De marcador a marcador de una cuadrícula; lado de una casilla ChArUco</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="92"/>
        <source>Pitch</source>
        <translation>Paso</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="93"/>
        <source>&amp;Poses, speed</source>
        <translation>&amp;Posturas, veloc.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="94"/>
        <source>Number of poses from which the robot looks at the board</source>
        <translation>Desde cuántas posturas mira el robot el tablero</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="94"/>
        <source> %</source>
        <translation> %</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="94"/>
        <source>All motion is slowed down to this share of its speed</source>
        <translation>Todo movimiento se frena a esta parte de su velocidad</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="94"/>
        <source>Speed</source>
        <translation>Velocidad</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="98"/>
        <source>&amp;Take the printed calibration board</source>
        <translation>&amp;Usar el tablero de calibración impreso</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="99"/>
        <source>The board that Calibrate camera saves for printing: ChArUco, 8 × 6 squares of 30 mm</source>
        <translation>El tablero que Calibrar cámara guarda para imprimir: ChArUco, 8 × 6 casillas de 30 mm</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="114"/>
        <source>Nobody is within reach of the robot</source>
        <translation>No hay nadie al alcance del robot</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="115"/>
        <source>Nobody is within the robot&apos;s reach, and its own emergency stop is within mine.</source>
        <translation>No hay nadie al alcance del robot, y su propia parada de emergencia está al mío.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="127"/>
        <source>%v of %m poses</source>
        <translation>%v de %m posturas</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="130"/>
        <source>Events</source>
        <translation>Sucesos</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="134"/>
        <source>Time</source>
        <translation>Tiempo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="135"/>
        <source>Event</source>
        <translation>Suceso</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="148"/>
        <source>Poses</source>
        <translation>Posturas</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="152"/>
        <source>Pose</source>
        <translation>Post.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="153"/>
        <source>Residual</source>
        <translation>Residuo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="154"/>
        <source>Joints, °</source>
        <translation>Articulaciones, °</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="158"/>
        <source>&amp;Frames</source>
        <translation>S&amp;istemas</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="159"/>
        <source>Name in tf of the frame on which the camera is mounted</source>
        <translation>Nombre en tf del soporte de la cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="161"/>
        <source>Frame of the camera</source>
        <translation>Sistema de la cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="161"/>
        <source>Name in tf of the camera&apos;s optical frame</source>
        <translation>Nombre en tf del sistema óptico de la cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/hand_eye_dialog.py" line="269"/>
        <source>&amp;Use now</source>
        <translation>&amp;Usar ahora</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/hand_eye_dialog.py" line="275"/>
        <source>Publish in &amp;tf</source>
        <translation>Publicar en &amp;tf</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="167"/>
        <source>On /tf_static over ROS 2, until this window&apos;s program ends or this button is released</source>
        <translation>En /tf_static por ROS 2, hasta que termine el programa de esta ventana o se suelte este botón</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/hand_eye_dialog.py" line="157"/>
        <source>Bac&amp;k</source>
        <translation>&amp;Atrás</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="178"/>
        <source>Close</source>
        <translation>Cerrar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/hand_eye_dialog.py" line="149"/>
        <source>&amp;Next</source>
        <translation>&amp;Siguiente</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/hand_eye_dialog.py" line="147"/>
        <source>Setup</source>
        <translation>Preparación</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/hand_eye_dialog.py" line="147"/>
        <source>Plan</source>
        <translation>Plan</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/hand_eye_dialog.py" line="147"/>
        <source>Motion</source>
        <translation>Movimiento</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/hand_eye_dialog.py" line="147"/>
        <source>Result</source>
        <translation>Resultado</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/hand_eye_dialog.py" line="149"/>
        <source>&amp;Let the robot move</source>
        <translation>&amp;Mover el robot</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/hand_eye_dialog.py" line="149"/>
        <source>C&amp;ompute</source>
        <translation>&amp;Calcular</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/hand_eye_dialog.py" line="149"/>
        <source>&amp;Save…</source>
        <translation>&amp;Guardar…</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/hand_eye_dialog.py" line="157"/>
        <source>Start a&amp;gain</source>
        <translation>&amp;Empezar de nuevo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/hand_eye_dialog.py" line="165"/>
        <source>Starting</source>
        <translation>Empezando</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/hand_eye_dialog.py" line="173"/>
        <source>Where is the camera of &lt;b&gt;{0}&lt;/b&gt;?</source>
        <translation>¿Dónde está la cámara de &lt;b&gt;{0}&lt;/b&gt;?</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/hand_eye_dialog.py" line="204"/>
        <source>the target is seen</source>
        <translation>se ve el objetivo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/hand_eye_dialog.py" line="224"/>
        <source>{0} left</source>
        <translation>quedan {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/hand_eye_dialog.py" line="247"/>
        <source>No other calibration of this camera is known</source>
        <translation>No se conoce otra calibración de esta cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/hand_eye_dialog.py" line="249"/>
        <source>Differs by {0}</source>
        <translation>Difiere en {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/hand_eye_dialog.py" line="253"/>
        <source>left out</source>
        <translation>excluida</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/hand_eye.ui" line="166"/>
        <source>Use this result for servoing instead of the previous one</source>
        <translation>Usar este resultado para el servocontrol en lugar del anterior</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/hand_eye_dialog.py" line="269"/>
        <source>In &amp;use</source>
        <translation>En &amp;uso</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/hand_eye_dialog.py" line="275"/>
        <source>On &amp;tf</source>
        <translation>En &amp;tf</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/hand_eye_dialog.py" line="331"/>
        <source>Bring the board into the middle of the image; it must not move on its own.</source>
        <translation>Lleve el tablero al centro de la imagen; no debe moverse por sí solo.</translation>
    </message>
</context>
<context>
    <name>HistogramPanel</name>
    <message>
        <location filename="../../grabbergui/ui/forms/histogram_panel.ui" line="15"/>
        <source>Mean, saturated and black</source>
        <translation>Media, saturado y negro</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/histogram_panel.ui" line="48"/>
        <source>Counts on a logarithmic scale</source>
        <translation>Recuento en escala logarítmica</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/histogram_panel.ui" line="49"/>
        <source>&amp;Log</source>
        <translation>&amp;Log.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/histogram_panel.ui" line="42"/>
        <source>Show the sensor’s whole range again</source>
        <translation>Mostrar de nuevo todo el rango del sensor</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/histogram_panel.ui" line="43"/>
        <source>Whole range</source>
        <translation>Todo el rango</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/histogram_panel.ui" line="24"/>
        <source>Histogram</source>
        <translation>Histograma</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/histogram_panel.ui" line="36"/>
        <source>Stretch the levels over 99 % of the image; the camera and saved frames do not change</source>
        <translation>Mostrar de negro a blanco lo que ocupa el 99 % de la imagen; la cámara y lo que se guarda no cambian</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/histogram_panel.ui" line="37"/>
        <source>Fit levels</source>
        <translation>Ajustar niveles</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/measuring_panels.py" line="90"/>
        <source>Mean {0}    {1:.2%} saturated    {2:.2%} black</source>
        <translation>Media {0}    {1:.2%} saturado    {2:.2%} negro</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/measuring_panels.py" line="86"/>
        <source>grey</source>
        <translation>gris</translation>
    </message>
</context>
<context>
    <name>Image</name>
    <message>
        <location filename="../../grabbergui/models/image/live_image.py" line="268"/>
        <source>frame {0} ({1}) cannot be shown: {2}</source>
        <translation>no se puede mostrar el fotograma {0} ({1}): {2}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/image/pixel_text.py" line="86"/>
        <source>no data</source>
        <translation>sin datos</translation>
    </message>
</context>
<context>
    <name>ImageNote</name>
    <message>
        <location filename="../../grabbergui/ui/forms/image_note.ui" line="34"/>
        <source>The stages of an image, and where it is lost</source>
        <translation>Las etapas de una imagen, y dónde se pierde</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/widgets/image_note.py" line="73"/>
        <source>control</source>
        <translation>control</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/widgets/image_note.py" line="74"/>
        <source>packets</source>
        <translation>paquetes</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/widgets/image_note.py" line="75"/>
        <source>frames</source>
        <translation>imágenes</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/widgets/image_note.py" line="76"/>
        <source>conversion</source>
        <translation>conversión</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/widgets/image_note.py" line="77"/>
        <source>display</source>
        <translation>pantalla</translation>
    </message>
</context>
<context>
    <name>ImageView</name>
    <message>
        <location filename="../../grabbergui/ui/forms/image_view.ui" line="57"/>
        <source>Live image</source>
        <translation>Imagen en directo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/image_view.ui" line="83"/>
        <source>Pixel under the cursor and the sensor&apos;s value there</source>
        <translation>Píxel bajo el cursor y el valor del sensor en él</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/image_view.ui" line="84"/>
        <source>Pixel under the cursor</source>
        <translation>Píxel bajo el cursor</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/image_view.ui" line="77"/>
        <source>What to do</source>
        <translation>Qué hacer</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/image_view.py" line="239"/>
        <source>Draw the region that the camera should send; Esc cancels.</source>
        <translation>Dibuje la región que la cámara debe enviar; Esc cancela.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/image_view.py" line="240"/>
        <source>Draw the region to bring into focus; Esc cancels.</source>
        <translation>Dibuje la región que debe ser nítida; Esc cancela.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/image_view.py" line="241"/>
        <source>Draw the line whose values you want to see; Esc cancels.</source>
        <translation>Dibuje la línea cuyos valores se mostrarán; Esc cancela.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/image_view.py" line="242"/>
        <source>Draw the region whose brightness counts; Esc cancels.</source>
        <translation>Dibuje la región cuyo brillo cuenta; Esc cancela.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/image_view.py" line="243"/>
        <source>Draw a region that should be grey; Esc cancels.</source>
        <translation>Dibuje una región que debería ser gris; Esc cancela.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/image_view.py" line="196"/>
        <source>Last image, {0} old</source>
        <translation>Última imagen, de hace {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/image_view.ui" line="26"/>
        <source>Component of the frame</source>
        <translation>Componente del fotograma</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/image_view.ui" line="27"/>
        <source>Which of the images in each frame is shown</source>
        <translation>Cuál de las imágenes de cada fotograma se muestra</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/image_view.ui" line="32"/>
        <source>Side by side</source>
        <translation>Lado a lado</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/image_view.ui" line="33"/>
        <source>Show all images of each frame at once; zoom, position and cursor are common to all. A click on one makes it the current one.</source>
        <translation>Muestra a la vez todas las imágenes de cada fotograma; el aumento, la posición y el cursor son comunes a todas. Con un clic en una, pasa a ser la actual.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/image_view.py" line="246"/>
        <source>Draw a line; Esc cancels.</source>
        <translation>Dibuje una línea; Esc cancela.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/image_view.py" line="247"/>
        <source>Draw a region; Esc cancels.</source>
        <translation>Dibuje una región; Esc cancela.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/image_view.py" line="225"/>
        <source>Draw a region, or drag the handles of this one; Esc ends.</source>
        <translation>Dibuje una región o arrastre los tiradores de esta; Esc termina.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/image_view.py" line="225"/>
        <source>Draw, or drag handles; Esc ends.</source>
        <translation>Dibuje o arrastre; Esc termina.</translation>
    </message>
</context>
<context>
    <name>IpAddress</name>
    <message>
        <location filename="../../grabbergui/models/ip_address.py" line="99"/>
        <source>The camera has the address {0}, also after its next start.</source>
        <translation>La cámara tiene la dirección {0}, también tras su próximo arranque.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/ip_address.py" line="101"/>
        <source>The camera has the address {0} until it is switched off.</source>
        <translation>La cámara tiene la dirección {0} hasta que se apague.</translation>
    </message>
</context>
<context>
    <name>IpAddressController</name>
    <message>
        <location filename="../../grabbergui/ui/controllers/ip_address.py" line="36"/>
        <source>Its address is {0}.</source>
        <translation>Su dirección es {0}.</translation>
    </message>
</context>
<context>
    <name>IpAddressDialog</name>
    <message>
        <location filename="../../grabbergui/ui/forms/ip_address.ui" line="6"/>
        <source>IP address of the camera</source>
        <translation>Dirección IP de la cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/ip_address.ui" line="22"/>
        <source>&amp;Address</source>
        <translation>&amp;Dirección</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/ip_address.ui" line="24"/>
        <source>Subnet &amp;mask</source>
        <translation>&amp;Máscara de subred</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/ip_address.ui" line="26"/>
        <source>&amp;Gateway</source>
        <translation>&amp;Puerta de enlace</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/ip_address.ui" line="27"/>
        <source>none</source>
        <translation>ninguna</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/ip_address.ui" line="32"/>
        <source>Write it as the persistent address; otherwise the camera has it until it is switched off</source>
        <translation>Escribirla como dirección persistente; si no, la cámara la tiene hasta que se apague</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/ip_address.ui" line="33"/>
        <source>&amp;Keep it after power-off (persistent IP)</source>
        <translation>&amp;Conservarla tras apagar (IP persistente)</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/ip_address.ui" line="50"/>
        <source>&amp;Set the address</source>
        <translation>&amp;Asignar la dirección</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/ip_address.ui" line="51"/>
        <source>Close</source>
        <translation>Cerrar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/ip_address_dialog.py" line="59"/>
        <source>Waiting for the camera…</source>
        <translation>Esperando a la cámara…</translation>
    </message>
</context>
<context>
    <name>LastFramesController</name>
    <message>
        <location filename="../../grabbergui/ui/controllers/last_frames.py" line="33"/>
        <source>there is no frame to save yet; start the camera first</source>
        <translation>todavía no hay ningún fotograma que guardar; inicie antes la cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/last_frames.py" line="37"/>
        <source>Saving the last {0} frames</source>
        <translation>Guardando los últimos {0} fotogramas</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/last_frames.py" line="37"/>
        <source>Saving the last frame</source>
        <translation>Guardando el último fotograma</translation>
    </message>
</context>
<context>
    <name>LogPanel</name>
    <message>
        <location filename="../../grabbergui/ui/forms/log_panel.ui" line="18"/>
        <source>The lowest level of the entries to show</source>
        <translation>Las entradas menos graves que se muestran</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/log_panel.ui" line="19"/>
        <source>Lowest level</source>
        <translation>Nivel mínimo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/log_panel.ui" line="20"/>
        <source>Everything</source>
        <translation>Todo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/log_panel.ui" line="21"/>
        <source>Warnings and errors</source>
        <translation>Avisos y errores</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/log_panel.ui" line="22"/>
        <source>Errors</source>
        <translation>Errores</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/log_panel.ui" line="33"/>
        <source>Copy what is shown</source>
        <translation>Copiar lo que se muestra</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/log_panel.ui" line="34"/>
        <source>Copy</source>
        <translation>Copiar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/log_panel.ui" line="39"/>
        <source>Forget all entries</source>
        <translation>Olvidar todas las entradas</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/log_panel.ui" line="40"/>
        <source>Clear</source>
        <translation>Vaciar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/log_panel.ui" line="47"/>
        <source>Log</source>
        <translation>Registro</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/log_panel.ui" line="50"/>
        <source>Messages of the program and its drivers appear here.</source>
        <translation>Aquí aparece lo que dicen el programa y sus controladores.</translation>
    </message>
</context>
<context>
    <name>LutController</name>
    <message>
        <location filename="../../grabbergui/ui/controllers/lut.py" line="86"/>
        <source>Reading the look-up table</source>
        <translation>Leyendo la tabla de consulta</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/lut.py" line="143"/>
        <source>Tables (*.csv *.txt *.bin *.raw);;All files (*)</source>
        <translation>Tablas (*.csv *.txt *.bin *.raw);;Todos los archivos (*)</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/lut.py" line="144"/>
        <source>Load a look-up table</source>
        <translation>Cargar una tabla de consulta</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/lut.py" line="155"/>
        <source>Comma-separated values (*.csv);;16-bit values (*.bin)</source>
        <translation>Valores separados por comas (*.csv);;Valores de 16 bits (*.bin)</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/lut.py" line="156"/>
        <source>Save the look-up table</source>
        <translation>Guardar la tabla de consulta</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/lut.py" line="158"/>
        <source>Saved {0}</source>
        <translation>Se guardó {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/lut.py" line="176"/>
        <source>The camera has the new look-up table</source>
        <translation>La cámara tiene la nueva tabla de consulta</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/lut.py" line="191"/>
        <source>Writing the look-up table</source>
        <translation>Escribiendo la tabla de consulta</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/lut.py" line="203"/>
        <source>Switching the look-up table</source>
        <translation>Conmutando la tabla de consulta</translation>
    </message>
</context>
<context>
    <name>LutDialog</name>
    <message>
        <location filename="../../grabbergui/ui/views/lut_dialog.py" line="56"/>
        <source>Look-up table</source>
        <translation>Tabla de consulta</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/lut_dialog.py" line="58"/>
        <source>&amp;Table</source>
        <translation>&amp;Tabla</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/lut_dialog.py" line="61"/>
        <source>The camera &amp;uses it</source>
        <translation>La cámara la &amp;usa</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/lut_dialog.py" line="63"/>
        <source>Curve of the look-up table</source>
        <translation>Curva de la tabla de consulta</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/lut_dialog.py" line="64"/>
        <source>Horizontal: value of the sensor; vertical: value that is sent instead</source>
        <translation>A la derecha: valor del sensor; hacia arriba: valor que se envía en su lugar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/lut_dialog.py" line="76"/>
        <source>Gamma</source>
        <translation>Gamma</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/lut_dialog.py" line="77"/>
        <source>Below 1, dark parts become brighter; above 1, darker</source>
        <translation>Por debajo de 1, las partes oscuras se aclaran; por encima de 1, se oscurecen</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/lut_dialog.py" line="78"/>
        <source>&amp;Gamma</source>
        <translation>G&amp;amma</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/lut_dialog.py" line="80"/>
        <source>Li&amp;near</source>
        <translation>Li&amp;neal</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/lut_dialog.py" line="81"/>
        <source>L&amp;oad…</source>
        <translation>Ca&amp;rgar…</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/lut_dialog.py" line="82"/>
        <source>&amp;Save…</source>
        <translation>&amp;Guardar…</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/lut_dialog.py" line="85"/>
        <source>Un&amp;do</source>
        <translation>&amp;Deshacer</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/lut_dialog.py" line="86"/>
        <source>Write back the camera&apos;s previous table</source>
        <translation>Vuelve a escribir la tabla que la cámara tenía antes</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/lut_dialog.py" line="87"/>
        <source>&amp;Write to the camera</source>
        <translation>&amp;Escribir en la cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/lut_dialog.py" line="88"/>
        <source>&amp;Close</source>
        <translation>&amp;Cerrar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/lut_dialog.py" line="114"/>
        <source>{0} entries</source>
        <translation>{0} valores</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/lut_dialog.py" line="115"/>
        <source>not written yet</source>
        <translation>aún sin escribir</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/lut_dialog.py" line="115"/>
        <source>as in the camera</source>
        <translation>como la tiene la cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/lut_dialog.py" line="67"/>
        <source>Input (LUTIndex)</source>
        <translation>Entrada (LUTIndex)</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/lut_dialog.py" line="67"/>
        <source>Output (LUTValue)</source>
        <translation>Salida (LUTValue)</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/lut_dialog.py" line="68"/>
        <source>in the camera</source>
        <translation>en la cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/lut_dialog.py" line="68"/>
        <source>edited</source>
        <translation>editada</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/lut_dialog.py" line="191"/>
        <source>Discard the edited table?</source>
        <translation>¿Descartar la tabla editada?</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/lut_dialog.py" line="191"/>
        <source>It is neither in the camera nor saved in a file.</source>
        <translation>No está en la cámara ni guardada en un archivo.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/lut_dialog.py" line="197"/>
        <source>&amp;Discard</source>
        <translation>&amp;Descartar</translation>
    </message>
</context>
<context>
    <name>MainWindow</name>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="6"/>
        <source>grabbergui</source>
        <translation>grabbergui</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="31"/>
        <source>&amp;Camera</source>
        <translation>&amp;Cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="59"/>
        <source>&amp;Edit</source>
        <translation>&amp;Editar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="64"/>
        <source>&amp;Image</source>
        <translation>&amp;Imagen</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="90"/>
        <source>&amp;View</source>
        <translation>&amp;Ver</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="92"/>
        <source>&amp;Theme</source>
        <translation>&amp;Tema</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="135"/>
        <source>&amp;Tools</source>
        <translation>&amp;Herramientas</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="148"/>
        <source>&amp;Help</source>
        <translation>A&amp;yuda</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="168"/>
        <source>Tools</source>
        <translation>Herramientas</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="186"/>
        <source>Sources</source>
        <translation>Fuentes</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="192"/>
        <source>Features</source>
        <translation>Parámetros</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="198"/>
        <source>Histogram</source>
        <translation>Histograma</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="205"/>
        <source>Focus aid</source>
        <translation>Ayuda de enfoque</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="212"/>
        <source>Line profile</source>
        <translation>Perfil de línea</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="219"/>
        <source>Values over time</source>
        <translation>Valores en el tiempo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="226"/>
        <source>Changes</source>
        <translation>Cambios</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="233"/>
        <source>Log</source>
        <translation>Registro</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="240"/>
        <source>&amp;Undo</source>
        <translation>&amp;Deshacer</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="241"/>
        <source>Undo the last change</source>
        <translation>Deshacer el último cambio</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="242"/>
        <source>Ctrl+Z</source>
        <translation>Ctrl+Z</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="246"/>
        <source>&amp;Redo</source>
        <translation>&amp;Rehacer</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="247"/>
        <source>Redo the change that was undone last</source>
        <translation>Rehacer lo que se deshizo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="248"/>
        <source>Ctrl+Shift+Z</source>
        <translation>Ctrl+Shift+Z</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="252"/>
        <source>&amp;Connect</source>
        <translation>&amp;Conectar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="253"/>
        <source>Connect to the chosen source</source>
        <translation>Conectar con la fuente elegida</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="254"/>
        <source>Ctrl+K</source>
        <translation>Ctrl+K</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="262"/>
        <source>&amp;Disconnect</source>
        <translation>Descon&amp;ectar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="263"/>
        <source>Close the current source</source>
        <translation>Soltar la cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="264"/>
        <source>Ctrl+D</source>
        <translation>Ctrl+D</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="268"/>
        <source>Open &amp;beside</source>
        <translation>Abrir al &amp;lado</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="269"/>
        <source>Open the chosen source in a tile; the current one stays open</source>
        <translation>Abrir la fuente elegida en una miniatura y dejar la otra como está</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="270"/>
        <source>Ctrl+B</source>
        <translation>Ctrl+B</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="275"/>
        <source>Make the next open source the current one</source>
        <translation>Hacer activa la siguiente de las fuentes abiertas</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="276"/>
        <source>F10</source>
        <translation>F10</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="279"/>
        <source>&amp;Start</source>
        <translation>&amp;Iniciar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="280"/>
        <source>Start streaming</source>
        <translation>Iniciar la adquisición</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="281"/>
        <source>F6</source>
        <translation>F6</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="285"/>
        <source>S&amp;top</source>
        <translation>&amp;Parar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="286"/>
        <source>Stop streaming</source>
        <translation>Parar la adquisición</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="287"/>
        <source>F7</source>
        <translation>F7</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="291"/>
        <source>S&amp;napshot</source>
        <translation>Cap&amp;turar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="293"/>
        <source>Ctrl+S</source>
        <translation>Ctrl+S</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="310"/>
        <source>Snapshot &amp;folder…</source>
        <translation>&amp;Carpeta de capturas…</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="311"/>
        <source>Choose where snapshots go</source>
        <translation>Elegir dónde se guardan las capturas</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="318"/>
        <source>&amp;Record or stop recording</source>
        <translation>&amp;Grabar o dejar de grabar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="319"/>
        <source>Ctrl+R</source>
        <translation>Ctrl+R</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="323"/>
        <source>Ctrl+Shift+S</source>
        <translation>Ctrl+Shift+S</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="324"/>
        <source>Save all settings of the camera to a file</source>
        <translation>Guardar todos los ajustes de la cámara en un archivo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="327"/>
        <source>&amp;Load settings…</source>
        <translation>Cargar a&amp;justes…</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="328"/>
        <source>Ctrl+Shift+O</source>
        <translation>Ctrl+Shift+O</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="329"/>
        <source>Load settings from a file, and show the outcome of each</source>
        <translation>Ajustar la cámara según un archivo y mostrar qué ha sido de cada ajuste</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="332"/>
        <source>Co&amp;mpare with settings…</source>
        <translation>C&amp;omparar con ajustes…</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="333"/>
        <source>Show what loading a file would change</source>
        <translation>Mostrar qué cambiaría al cargar un archivo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="349"/>
        <source>&amp;Quit</source>
        <translation>&amp;Salir</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="350"/>
        <source>Ctrl+Q</source>
        <translation>Ctrl+Q</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="355"/>
        <source>&amp;Fit</source>
        <translation>&amp;Encajar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="356"/>
        <source>Show the whole image</source>
        <translation>Mostrar toda la imagen</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="357"/>
        <source>F</source>
        <translation>F</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="361"/>
        <source>&amp;1:1</source>
        <translation>&amp;1:1</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="362"/>
        <source>One screen pixel for each pixel of the image</source>
        <translation>Un píxel de pantalla por cada píxel de la imagen</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="363"/>
        <source>1</source>
        <translation>1</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="367"/>
        <source>Zoom &amp;in</source>
        <translation>&amp;Ampliar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="368"/>
        <source>Zoom in; the mouse wheel does too</source>
        <translation>Ampliar; también con la rueda del ratón</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="369"/>
        <source>Ctrl++</source>
        <translation>Ctrl++</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="373"/>
        <source>Zoom &amp;out</source>
        <translation>Re&amp;ducir</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="374"/>
        <source>Zoom out</source>
        <translation>Reducir</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="375"/>
        <source>Ctrl+-</source>
        <translation>Ctrl+-</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="379"/>
        <source>&amp;Pause</source>
        <translation>&amp;Pausa</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="380"/>
        <source>Pause the image; the last frames can be stepped through</source>
        <translation>Pausar la imagen; se pueden recorrer las últimas</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="381"/>
        <source>P</source>
        <translation>P</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="386"/>
        <source>Step &amp;back</source>
        <translation>Imagen a&amp;nterior</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="387"/>
        <source>Show the previous frame; pauses</source>
        <translation>Mostrar la imagen anterior; pone en pausa</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="388"/>
        <source>,</source>
        <translation>,</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="392"/>
        <source>Step f&amp;orward</source>
        <translation>Imagen &amp;siguiente</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="393"/>
        <source>Show the next frame</source>
        <translation>Mostrar la imagen siguiente</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="394"/>
        <source>.</source>
        <translation>.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="400"/>
        <source>Ctrl+E</source>
        <translation>Ctrl+E</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="404"/>
        <source>F&amp;ull sensor</source>
        <translation>Sensor completo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="406"/>
        <source>Ctrl+Shift+E</source>
        <translation>Ctrl+Shift+E</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="434"/>
        <source>&amp;Clipping</source>
        <translation>Marcar &amp;saturados</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="435"/>
        <source>Mark saturated pixels red and black ones blue</source>
        <translation>Marcar en rojo los píxeles saturados y en azul los negros</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="436"/>
        <source>X</source>
        <translation>X</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="441"/>
        <source>C&amp;rosshair</source>
        <translation>&amp;Cruz</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="442"/>
        <source>Mark the middle of the image</source>
        <translation>Marcar el centro de la imagen</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="443"/>
        <source>C</source>
        <translation>C</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="447"/>
        <source>&amp;Grid</source>
        <translation>Cuadrícu&amp;la</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="448"/>
        <source>Divide the image into thirds and more</source>
        <translation>Dividir la imagen en tercios y más</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="449"/>
        <source>G</source>
        <translation>G</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="453"/>
        <source>Turn ri&amp;ght</source>
        <translation>Girar a la &amp;derecha</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="454"/>
        <source>Turn the view clockwise; the frames stay as they are</source>
        <translation>Girar la vista en sentido horario; las imágenes no cambian</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="455"/>
        <source>R</source>
        <translation>R</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="459"/>
        <source>Turn &amp;left</source>
        <translation>Girar a la &amp;izquierda</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="460"/>
        <source>Turn the view anticlockwise</source>
        <translation>Girar la vista en sentido antihorario</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="461"/>
        <source>Shift+R</source>
        <translation>Shift+R</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="464"/>
        <source>&amp;Mirror left and right</source>
        <translation>R&amp;eflejar izquierda y derecha</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="470"/>
        <source>Mirror the view</source>
        <translation>Reflejar la vista</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="466"/>
        <source>M</source>
        <translation>M</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="469"/>
        <source>Mirror top and &amp;bottom</source>
        <translation>Reflejar arriba y a&amp;bajo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="471"/>
        <source>Shift+M</source>
        <translation>Shift+M</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="474"/>
        <source>As the &amp;camera sends it</source>
        <translation>Como la envía la &amp;cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="475"/>
        <source>Neither turned nor mirrored</source>
        <translation>Ni girada ni reflejada</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="478"/>
        <source>F&amp;ull screen</source>
        <translation>&amp;Pantalla completa</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="480"/>
        <source>F11</source>
        <translation>F11</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="493"/>
        <source>&amp;Address…</source>
        <translation>&amp;Dirección…</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="494"/>
        <source>Type the address of a source</source>
        <translation>Escribir la dirección de una fuente</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="495"/>
        <source>Ctrl+L</source>
        <translation>Ctrl+L</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="498"/>
        <source>S&amp;earch again</source>
        <translation>B&amp;uscar de nuevo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="527"/>
        <source>&amp;Find a feature</source>
        <translation>&amp;Buscar un parámetro</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="528"/>
        <source>Filter the camera&apos;s features by name</source>
        <translation>Filtrar los parámetros de la cámara por nombre</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="529"/>
        <source>Ctrl+F</source>
        <translation>Ctrl+F</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="532"/>
        <source>&amp;Calibrate camera…</source>
        <translation>&amp;Calibrar la cámara…</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="533"/>
        <source>Find focal length and distortion with a printed board, for distances and for ROS</source>
        <translation>Hallar distancia focal y distorsión con un tablero impreso, para medir distancias y para ROS</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="563"/>
        <source>&amp;Keyboard shortcuts</source>
        <translation>&amp;Atajos de teclado</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="564"/>
        <source>F1</source>
        <translation>F1</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="567"/>
        <source>&amp;About grabbergui</source>
        <translation>A&amp;cerca de grabbergui</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="571"/>
        <source>&amp;As the desktop</source>
        <translation>&amp;Como el escritorio</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="575"/>
        <source>&amp;Light</source>
        <translation>C&amp;laro</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="579"/>
        <source>&amp;Dark</source>
        <translation>&amp;Oscuro</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/main_window.py" line="358"/>
        <source>Grey</source>
        <translation>Gris</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="98"/>
        <source>Orie&amp;ntation</source>
        <translation>&amp;Orientación</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="107"/>
        <source>Colours of gre&amp;y images</source>
        <translation>Colores de imágenes en &amp;gris</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="315"/>
        <source>Open snapshot fold&amp;er</source>
        <translation>&amp;Abrir la carpeta de capturas</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="322"/>
        <source>Sa&amp;ve settings…</source>
        <translation>&amp;Guardar ajustes…</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="398"/>
        <source>Re&amp;gion…</source>
        <translation>&amp;Región…</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="410"/>
        <source>&amp;Expose once</source>
        <translation>&amp;Exponer una vez</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="412"/>
        <source>Set exposure time and gain by the whole image, once</source>
        <translation>Ajustar una vez la exposición y la ganancia según toda la imagen</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="413"/>
        <source>E</source>
        <translation>E</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="417"/>
        <source>Expose on a &amp;region…</source>
        <translation>E&amp;xponer según una región…</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="418"/>
        <source>Draw the region whose brightness counts; exposure time and gain are set by it, once</source>
        <translation>Dibujar la región cuyo brillo cuenta; la exposición y la ganancia se ajustan una vez según ella</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="419"/>
        <source>Shift+E</source>
        <translation>Shift+E</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="422"/>
        <source>&amp;White balance once</source>
        <translation>&amp;Balance de blancos una vez</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="424"/>
        <source>Set the white balance by the whole image, once</source>
        <translation>Ajustar una vez el balance de blancos según toda la imagen</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="425"/>
        <source>W</source>
        <translation>W</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="429"/>
        <source>White &amp;balance on a region…</source>
        <translation>Ba&amp;lance de blancos en una región…</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="430"/>
        <source>Draw a region that should be grey; the ratios of red and blue are set by it, once</source>
        <translation>Dibujar una región que debería ser gris; las proporciones de rojo y azul se ajustan una vez según ella</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="431"/>
        <source>Shift+W</source>
        <translation>Shift+W</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="336"/>
        <source>Compare t&amp;wo files of settings…</source>
        <translation>Comparar dos arc&amp;hivos de ajustes…</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="337"/>
        <source>Show the differences of two files, and load the values of either</source>
        <translation>Mostrar en qué difieren dos archivos y ajustar la cámara según uno de ellos</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="340"/>
        <source>Settings &amp;kept in the camera…</source>
        <translation>Ajustes en la cá&amp;mara…</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="341"/>
        <source>Load and save the sets that the camera keeps itself, and choose which one it starts with</source>
        <translation>Cargar y guardar los juegos que conserva la propia cámara y elegir con cuál arranca</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="342"/>
        <source>Ctrl+U</source>
        <translation>Ctrl+U</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="399"/>
        <source>Draw the part of the sensor that the camera sends; this pauses the stream for a moment</source>
        <translation>Dibujar la parte del sensor que la cámara debe enviar; esto detiene la captura un momento</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="405"/>
        <source>Let the camera send the whole sensor again; this pauses the stream for a moment</source>
        <translation>Que la cámara vuelva a enviar todo el sensor; esto detiene la captura un momento</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="537"/>
        <source>&amp;Load calibration…</source>
        <translation>Car&amp;gar calibración…</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="538"/>
        <source>Read a camera_info file, and show the image without the distortion it describes</source>
        <translation>Leer un archivo camera_info y mostrar la imagen sin la distorsión que describe</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="541"/>
        <source>&amp;Show calibration</source>
        <translation>&amp;Mostrar calibración</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="542"/>
        <source>Show the image without the lens&apos;s distortion; the camera and saved frames do not change</source>
        <translation>Mostrar la imagen sin la distorsión del objetivo; no cambian ni la cámara ni lo que se guarda</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="546"/>
        <source>&amp;Manual</source>
        <translation>&amp;Manual</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="547"/>
        <source>Open the manual</source>
        <translation>Leer el manual</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="550"/>
        <source>&amp;What&apos;s this?</source>
        <translation>¿&amp;Qué es esto?</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="551"/>
        <source>Click on anything to read what it does</source>
        <translation>Pulsar sobre cualquier cosa para leer lo que hace</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="552"/>
        <source>Shift+F1</source>
        <translation>Shift+F1</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="555"/>
        <source>&amp;Doctor…</source>
        <translation>&amp;Diagnóstico…</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="556"/>
        <source>Check this computer for the usual problems with cameras</source>
        <translation>Revisar en este equipo lo que suele fallar con las cámaras</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="259"/>
        <source>Connect to the chosen source without starting it, to set format and region first</source>
        <translation>Conectar con la fuente elegida y fijar formato y región antes de la primera imagen</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="258"/>
        <source>Connect wit&amp;hout starting</source>
        <translation>Conectar sin inici&amp;ar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="110"/>
        <source>&amp;Polarised mosaic</source>
        <translation>&amp;Mosaico polarizado</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/main_window.py" line="398"/>
        <source>As sent</source>
        <translation>Como se envía</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/main_window.py" line="399"/>
        <source>Intensity</source>
        <translation>Intensidad</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/main_window.py" line="400"/>
        <source>Degree of polarisation</source>
        <translation>Grado de polarización</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/main_window.py" line="401"/>
        <source>Angle of polarisation</source>
        <translation>Ángulo de polarización</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="292"/>
        <source>Save the newest frame at full resolution, each of its components: PNG, or TIFF for more than 8 bits</source>
        <translation>Guarda el último fotograma a resolución completa, cada uno de sus componentes: PNG, o TIFF con más de 8 bits</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="306"/>
        <source>Save point &amp;cloud</source>
        <translation>Guardar nube de p&amp;untos</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="307"/>
        <source>Save the points of the newest frame&apos;s range image as PLY, in millimetres</source>
        <translation>Guarda los puntos de la imagen de distancias del último fotograma en PLY, en milímetros</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="302"/>
        <source>Point clou&amp;d…</source>
        <translation>N&amp;ube de puntos…</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="303"/>
        <source>Show the points of the range image in a window, to turn with the mouse</source>
        <translation>Muestra en una ventana los puntos de la imagen de distancias, que se giran con el ratón</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="298"/>
        <source>&amp;Sensor has polarisers</source>
        <translation>El &amp;sensor tiene polarizadores</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="299"/>
        <source>Ticked automatically if the camera's features say so. Sony's arrangement of 90°, 45° over 135°, 0° is assumed.</source>
        <translation>Se marca solo cuando las características de la cámara lo indican. Se supone la disposición de Sony: 90°, 45° sobre 135°, 0°.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="345"/>
        <source>Loo&amp;k-up table…</source>
        <translation>&amp;Tabla de consulta…</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="346"/>
        <source>Show the camera&apos;s look-up table as a curve, edit it, and write it to the camera</source>
        <translation>Muestra la tabla de consulta de la cámara como una curva, para editarla y escribirla en la cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/main_window.py" line="342"/>
        <source>Close this panel; to open it again: {0}</source>
        <translation>Cerrar este panel; para volver a abrirlo: {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="559"/>
        <source>&amp;Report this camera…</source>
        <translation>&amp;Informe de esta cámara…</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="560"/>
        <source>Write all about the camera to one file, to attach to a bug report</source>
        <translation>Escribir todo sobre la cámara en un archivo, para adjuntarlo a un informe de error</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="69"/>
        <source>Snapshot for&amp;mat</source>
        <translation>For&amp;mato de captura</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="113"/>
        <source>Cameras &amp;side by side</source>
        <translation>Cámaras &amp;juntas</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="411"/>
        <source>Expose</source>
        <translation>Exponer</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="423"/>
        <source>White balance</source>
        <translation>Balance de blancos</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="479"/>
        <source>Show the image alone; exposure and gain appear when the mouse moves, Esc returns</source>
        <translation>Mostrar solo la imagen; la exposición y la ganancia aparecen al mover el ratón, Esc vuelve</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="484"/>
        <source>Cop&amp;y what is shown</source>
        <translation>Cop&amp;iar lo que se ve</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="485"/>
        <source>Copy the visible part of the image, as it is on the screen, to the clipboard</source>
        <translation>Copiar al portapapeles la parte visible de la imagen, tal como está en la pantalla</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="486"/>
        <source>Ctrl+Shift+C</source>
        <translation>Ctrl+Shift+C</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="489"/>
        <source>Reset &amp;layout</source>
        <translation>Restablecer disposició&amp;n</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="490"/>
        <source>Put all panels back where they were at the first start</source>
        <translation>Devolver todos los paneles al lugar del primer arranque</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="514"/>
        <source>Sha&amp;re…</source>
        <translation>Compar&amp;tir…</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="515"/>
        <source>Share the camera on YARP or ROS 2</source>
        <translation>Compartir la cámara en YARP o ROS 2</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="519"/>
        <source>Frame &amp;data…</source>
        <translation>&amp;Datos del fotograma…</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="520"/>
        <source>Number, times and chunk data of the shown frame</source>
        <translation>Número, tiempos y datos de chunk del fotograma mostrado</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="523"/>
        <source>Sa&amp;ve the last frames</source>
        <translation>Guardar los ú&amp;ltimos fotogramas</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="524"/>
        <source>Save the frames that Pause steps through, in a folder of their own</source>
        <translation>Guardar los fotogramas que recorre Pausa, en una carpeta propia</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/main_window.py" line="369"/>
        <source>&amp;{0}</source>
        <translation>&amp;{0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="66"/>
        <source>Frames to record</source>
        <translation>Imágenes que grabar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="503"/>
        <source>Events that the camera reports, such as edges on its lines and missed triggers</source>
        <translation>Eventos que comunica la cámara, como flancos en sus líneas y disparos perdidos</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="506"/>
        <source>New ri&amp;g…</source>
        <translation>&amp;Nuevo grupo de cámaras…</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="507"/>
        <source>Make one source of several cameras, whose frames come in sets</source>
        <translation>Hacer de varias cámaras una fuente cuyas imágenes llegan en conjuntos</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="510"/>
        <source>R&amp;ig…</source>
        <translation>G&amp;rupo de cámaras…</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="511"/>
        <source>Sets of the rig, their skew, the clocks of its cameras and the budget of its link</source>
        <translation>Conjuntos del grupo, su desfase, los relojes de sus cámaras y el presupuesto de su enlace</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/main_window.py" line="376"/>
        <source>Separate &amp;zoom</source>
        <translation>&amp;Zoom separado</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/main_window.py" line="378"/>
        <source>Zoom and move each camera by itself, not all alike</source>
        <translation>Ampliar y mover cada cámara por separado, no todas a la vez</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="274"/>
        <source>Ne&amp;xt open source</source>
        <translation>Siguiente &amp;fuente abierta</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/main_window.ui" line="502"/>
        <source>Eve&amp;nts…</source>
        <translation>E&amp;ventos…</translation>
    </message>
</context>
<context>
    <name>ManualDialog</name>
    <message>
        <location filename="../../grabbergui/ui/views/help_views.py" line="81"/>
        <source>Manual</source>
        <translation>Manual</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/help_views.py" line="85"/>
        <source>&amp;Back</source>
        <translation>&amp;Atrás</translation>
    </message>
</context>
<context>
    <name>MeasuringController</name>
    <message>
        <location filename="../../grabbergui/ui/controllers/measuring.py" line="124"/>
        <source>of {0} × {1} pixels at ({2}, {3})</source>
        <translation>de {0} × {1} píxeles en ({2}, {3})</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/measuring.py" line="153"/>
        <source>{0:.2%} saturated · {1:.2%} black</source>
        <translation>{0:.2%} saturado · {1:.2%} negro</translation>
    </message>
</context>
<context>
    <name>MessageBar</name>
    <message>
        <location filename="../../grabbergui/ui/forms/message_bar.ui" line="30"/>
        <source>Dismiss</source>
        <translation>Descartar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/message_bar.ui" line="29"/>
        <source>Dismiss this message</source>
        <translation>Descartar este mensaje</translation>
    </message>
</context>
<context>
    <name>MessageLine</name>
    <message>
        <location filename="../../grabbergui/ui/forms/message_line.ui" line="28"/>
        <source>Show the messages in full</source>
        <translation>Mostrar los mensajes completos</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/message_line.ui" line="37"/>
        <source>Dismiss</source>
        <translation>Descartar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/message_line.ui" line="36"/>
        <source>Dismiss this message</source>
        <translation>Descartar este mensaje</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/widgets/message_line.py" line="135"/>
        <source>{0} more</source>
        <translation>{0} más</translation>
    </message>
</context>
<context>
    <name>Messages</name>
    <message>
        <location filename="../../grabbergui/models/source_messages.py" line="44"/>
        <source>{0} could not be written: {1}</source>
        <translation>no se pudo escribir {0}: {1}</translation>
    </message>
</context>
<context>
    <name>NewRigController</name>
    <message>
        <location filename="../../grabbergui/rig/ui/controller.py" line="76"/>
        <source>File of the rig</source>
        <translation>Archivo del grupo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/controller.py" line="76"/>
        <source>Rigs (*.yaml)</source>
        <translation>Grupos (*.yaml)</translation>
    </message>
</context>
<context>
    <name>NewRigDialog</name>
    <message>
        <location filename="../../grabbergui/rig/ui/forms/new_rig.ui" line="6"/>
        <source>New rig</source>
        <translation>Nuevo grupo de cámaras</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/forms/new_rig.ui" line="10"/>
        <source>A rig is several cameras as one source: one trigger, one recording, frames in sets. Tick its cameras, and name them by a double click.</source>
        <translation>Un grupo son varias cámaras como una fuente: un disparo, una grabación, imágenes en conjuntos. Marque sus cámaras y nómbrelas con doble clic.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/forms/new_rig.ui" line="17"/>
        <source>Cameras of the rig</source>
        <translation>Cámaras del grupo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/forms/new_rig.ui" line="20"/>
        <source>Name</source>
        <translation>Nombre</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/forms/new_rig.ui" line="21"/>
        <source>Source</source>
        <translation>Fuente</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/forms/new_rig.ui" line="28"/>
        <source>Address of another camera</source>
        <translation>Dirección de otra cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/forms/new_rig.ui" line="29"/>
        <source>Another camera, such as gige:192.168.0.11</source>
        <translation>Otra cámara, como gige:192.168.0.11</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/forms/new_rig.ui" line="32"/>
        <source>&amp;Add</source>
        <translation>&amp;Añadir</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/forms/new_rig.ui" line="37"/>
        <source>&amp;Trigger</source>
        <translation>&amp;Disparo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/forms/new_rig.ui" line="40"/>
        <source>None: the cameras run freely</source>
        <translation>Ninguno: las cámaras corren libres</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/forms/new_rig.ui" line="41"/>
        <source>Software: a command to each camera</source>
        <translation>Software: una orden a cada cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/forms/new_rig.ui" line="42"/>
        <source>Action: one message to all (GigE Vision)</source>
        <translation>Acción: un mensaje a todas (GigE Vision)</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/forms/new_rig.ui" line="43"/>
        <source>Line: a camera or a signal triggers the others</source>
        <translation>Línea: una cámara o una señal dispara las demás</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/forms/new_rig.ui" line="46"/>
        <source>&amp;Rate</source>
        <translation>&amp;Frecuencia</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/forms/new_rig.ui" line="49"/>
        <source>Triggers per second; at 0 each is sent by hand</source>
        <translation>Disparos por segundo; con 0 se envía cada uno a mano</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/forms/new_rig.ui" line="55"/>
        <source>&amp;Leader</source>
        <translation>&amp;Líder</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/forms/new_rig.ui" line="56"/>
        <source>The camera whose output Line2 triggers the others at Line1</source>
        <translation>La cámara cuya salida Line2 dispara las demás en Line1</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/forms/new_rig.ui" line="68"/>
        <source>&amp;Save and open…</source>
        <translation>&amp;Guardar y abrir…</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/forms/new_rig.ui" line="69"/>
        <source>Cancel</source>
        <translation>Cancelar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/new_rig_dialog.py" line="105"/>
        <source>two cameras have one name; name each by a double click</source>
        <translation>dos cámaras tienen el mismo nombre; nombre cada una con doble clic</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/new_rig_dialog.py" line="123"/>
        <source>None: a signal from elsewhere</source>
        <translation>Ninguno: una señal externa</translation>
    </message>
</context>
<context>
    <name>NumberField</name>
    <message>
        <location filename="../../grabbergui/ui/editors/number_editors.py" line="219"/>
        <source>“{0}” is not a number</source>
        <translation>«{0}» no es un número</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/editors/number_editors.py" line="219"/>
        <source>“{0}” is not a number in {1}</source>
        <translation>«{0}» no es un número en {1}</translation>
    </message>
</context>
<context>
    <name>PauseBar</name>
    <message>
        <location filename="../../grabbergui/ui/forms/pause_bar.ui" line="14"/>
        <source>Frame that is shown</source>
        <translation>Imagen mostrada</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/pause_bar.ui" line="20"/>
        <source>Step through the last frames (, and .)</source>
        <translation>Recorrer las últimas imágenes (, y .)</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/pause_bar.ui" line="21"/>
        <source>Frame to show</source>
        <translation>Imagen que mostrar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/pause_bar.ui" line="30"/>
        <source>Show the live image again (P)</source>
        <translation>Volver a la imagen en directo (P)</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/pause_bar.ui" line="31"/>
        <source>Live</source>
        <translation>En directo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/recording_bars.py" line="362"/>
        <source>{0} of {1}   −{2:.2f} s</source>
        <translation>{0} de {1}   −{2:.2f} s</translation>
    </message>
</context>
<context>
    <name>PauseController</name>
    <message>
        <location filename="../../grabbergui/ui/controllers/recording.py" line="177"/>
        <source>there is no frame yet to pause at; start the camera first</source>
        <translation>todavía no hay imagen en la que pausar; inicie antes la cámara</translation>
    </message>
</context>
<context>
    <name>PlaybackBar</name>
    <message>
        <location filename="../../grabbergui/ui/forms/playback_bar.ui" line="6"/>
        <source>Playback</source>
        <translation>Reproducción</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/playback_bar.ui" line="15"/>
        <source>Back</source>
        <translation>Atrás</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/playback_bar.ui" line="16"/>
        <source>One frame back (,)</source>
        <translation>Una imagen atrás (,)</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/playback_bar.ui" line="17"/>
        <source>One frame back</source>
        <translation>Una imagen atrás</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/recording_bars.py" line="292"/>
        <source>Play</source>
        <translation>Reproducir</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/playback_bar.ui" line="25"/>
        <source>Play or pause (P)</source>
        <translation>Reproducir o pausar (P)</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/playback_bar.ui" line="33"/>
        <source>Forward</source>
        <translation>Adelante</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/playback_bar.ui" line="34"/>
        <source>One frame forward (.)</source>
        <translation>Una imagen adelante (.)</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/playback_bar.ui" line="35"/>
        <source>One frame forward</source>
        <translation>Una imagen adelante</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/playback_bar.ui" line="42"/>
        <source>Where the recording plays</source>
        <translation>Por dónde va la grabación</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/playback_bar.ui" line="43"/>
        <source>Position in the recording</source>
        <translation>Posición en la grabación</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/playback_bar.ui" line="52"/>
        <source>Time and frame in the recording</source>
        <translation>Tiempo e imagen en la grabación</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/playback_bar.ui" line="58"/>
        <source>Speed of playback; 1 is that of the recording</source>
        <translation>A qué velocidad se reproduce; 1 es la velocidad a la que se grabó</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/playback_bar.ui" line="59"/>
        <source>Speed</source>
        <translation>Velocidad</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/playback_bar.ui" line="66"/>
        <source>Loop</source>
        <translation>Bucle</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/playback_bar.ui" line="65"/>
        <source>Begin again at the end</source>
        <translation>Volver a empezar al final</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/recording_bars.py" line="292"/>
        <source>Pause</source>
        <translation>Pausa</translation>
    </message>
</context>
<context>
    <name>PointCloudDialog</name>
    <message>
        <location filename="../../grabbergui/ui/views/image_view.py" line="400"/>
        <source>Point cloud</source>
        <translation>Nube de puntos</translation>
    </message>
</context>
<context>
    <name>PointCloudView</name>
    <message>
        <location filename="../../grabbergui/ui/views/image_view.py" line="336"/>
        <source>Point cloud</source>
        <translation>Nube de puntos</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/image_view.py" line="337"/>
        <source>Drag to turn, wheel to zoom</source>
        <translation>Arrastre para girar; la rueda amplía</translation>
    </message>
</context>
<context>
    <name>ProfilePanel</name>
    <message>
        <location filename="../../grabbergui/ui/forms/profile_panel.ui" line="17"/>
        <source>Line</source>
        <translation>Línea</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/profile_panel.ui" line="35"/>
        <source>Draw the line whose values are shown</source>
        <translation>Dibujar la línea cuyos valores se muestran</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/profile_panel.ui" line="36"/>
        <source>Draw line</source>
        <translation>Dibujar línea</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/profile_panel.ui" line="43"/>
        <source>Values along the line</source>
        <translation>Valores a lo largo de la línea</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/measuring_panels.py" line="264"/>
        <source>The sensor&apos;s values over the pixels along the line</source>
        <translation>Los valores del sensor en los píxeles de la línea</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/measuring_panels.py" line="248"/>
        <source>Draw a line through the image to see its values.</source>
        <translation>Dibuje una línea en la imagen para ver sus valores.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/profile_panel.ui" line="29"/>
        <source>The sensor’s own values, of a Bayer pattern each under the colour of its filter; or else the colours shown, in 8 bits</source>
        <translation>Los valores propios del sensor, en un patrón Bayer cada uno bajo el color de su filtro; si no, los colores mostrados, en 8 bits</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/profile_panel.ui" line="30"/>
        <source>&amp;Raw values</source>
        <translation>Valores en &amp;bruto</translation>
    </message>
</context>
<context>
    <name>Program</name>
    <message>
        <location filename="../../grabbergui/ui/run/program.py" line="207"/>
        <source>Folder for snapshots</source>
        <translation>Carpeta de capturas</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/run/program.py" line="223"/>
        <source>About grabbergui</source>
        <translation>Acerca de grabbergui</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/run/program.py" line="223"/>
        <source>&lt;h3&gt;grabbergui {0}&lt;/h3&gt;&lt;p&gt;Tune GenICam cameras live, and share them on YARP and ROS 2 networks.&lt;/p&gt;&lt;p&gt;Free software under the GNU General Public License, version 3 or later, with an additional permission to combine it with the GenICam runtime.&lt;/p&gt;</source>
        <translation>&lt;h3&gt;grabbergui {0}&lt;/h3&gt;&lt;p&gt;Ajusta cámaras GenICam en directo y las comparte en redes YARP y ROS 2.&lt;/p&gt;&lt;p&gt;Software libre bajo la Licencia Pública General de GNU, versión 3 o posterior, con un permiso adicional para combinarlo con las bibliotecas de GenICam.&lt;/p&gt;</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/run/program.py" line="215"/>
        <source>{0} could not be opened: {1}</source>
        <translation>{0} no se pudo abrir: {1}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/run/program.py" line="218"/>
        <source>Snapshots are in {0}; no file manager could be started</source>
        <translation>Las capturas están en {0}; no se pudo abrir un gestor de archivos</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/run/program.py" line="78"/>
        <source>{0} cannot be written: the window will forget its arrangement and your choices</source>
        <translation>No se puede escribir {0}: la ventana olvidará su disposición y sus elecciones</translation>
    </message>
</context>
<context>
    <name>Recording</name>
    <message>
        <location filename="../../grabbergui/models/recording.py" line="198"/>
        <source>internal error, see the log: {0}</source>
        <translation>error interno, véase el registro: {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/recording.py" line="190"/>
        <source>the source was closed</source>
        <translation>se cerró la fuente</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/recording.py" line="186"/>
        <source>the disk of {0} is full ({1} MiB left)</source>
        <translation>el disco de {0} está lleno (quedan {1} MiB)</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/recording.py" line="200"/>
        <source>; {0} frames recorded by then are kept</source>
        <translation>; se conservan las {0} imágenes grabadas hasta entonces</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/recording.py" line="200"/>
        <source>; 1 frame recorded by then is kept</source>
        <translation>; se conserva 1 imagen grabada hasta entonces</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/recording.py" line="205"/>
        <source>; nothing was recorded</source>
        <translation>; no se grabó nada</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/recording.py" line="192"/>
        <source>{0} could not be finished: {1}</source>
        <translation>no se pudo terminar {0}: {1}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/recording.py" line="158"/>
        <source>the recording of {0} ended: {1}</source>
        <translation>la grabación de {0} terminó: {1}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/recording.py" line="161"/>
        <source>nothing was recorded of {0}</source>
        <translation>no se grabó nada de {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/recording.py" line="164"/>
        <source>1 frame</source>
        <translation>1 imagen</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/recording.py" line="164"/>
        <source>{0} frames</source>
        <translation>{0} imágenes</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/recording.py" line="167"/>
        <source>recorded {0} to {1}</source>
        <translation>grabación de {0} en {1}</translation>
    </message>
</context>
<context>
    <name>RecordingBar</name>
    <message>
        <location filename="../../grabbergui/ui/views/recording_bars.py" line="146"/>
        <source>Record</source>
        <translation>Grabar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/recording_bar.ui" line="15"/>
        <source>Record every frame from now on; press again to stop</source>
        <translation>Grabar cada imagen desde ahora; pulse otra vez para parar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/recording_bar.ui" line="27"/>
        <source>File format of the recording</source>
        <translation>Formato de la grabación</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/recording_bar.ui" line="28"/>
        <source>Kind of recording</source>
        <translation>Tipo de grabación</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/recording_bar.ui" line="35"/>
        <source>When the recording ends automatically</source>
        <translation>Cuándo acaba sola la grabación</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/recording_bar.ui" line="36"/>
        <source>End of the recording</source>
        <translation>Final de la grabación</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/recording_bar.ui" line="37"/>
        <source>Until stopped</source>
        <translation>Hasta pararla</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/recording_bar.ui" line="38"/>
        <source>For a time</source>
        <translation>Durante un tiempo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/recording_bar.ui" line="39"/>
        <source>For a number of frames</source>
        <translation>Un número de imágenes</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/recording_bar.ui" line="40"/>
        <source>Up to a size</source>
        <translation>Hasta un tamaño</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/recording_bar.ui" line="46"/>
        <source>Limit of the recording</source>
        <translation>Límite de la grabación</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/recording_bar.ui" line="47"/>
        <source>Length of the recording</source>
        <translation>Duración de la grabación</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/recording_bar.ui" line="55"/>
        <source>Folder</source>
        <translation>Carpeta</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/recording_bar.ui" line="56"/>
        <source>Choose where recordings go</source>
        <translation>Elegir dónde se guardan las grabaciones</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/recording_bar.ui" line="57"/>
        <source>Folder of recordings</source>
        <translation>Carpeta de grabaciones</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/recording_bars.py" line="203"/>
        <source>Play</source>
        <translation>Reproducir</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/recording_bar.ui" line="72"/>
        <source>Play the last recording in place of the camera</source>
        <translation>Reproducir la última grabación en lugar de la cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/recording_bar.ui" line="73"/>
        <source>Play the last recording</source>
        <translation>Reproducir la última grabación</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/recording_bars.py" line="185"/>
        <source>Movie (MP4)</source>
        <translation>Vídeo (MP4)</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/recording_bars.py" line="186"/>
        <source>Movie, lossless (MP4)</source>
        <translation>Vídeo sin pérdidas (MP4)</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/recording_bars.py" line="188"/>
        <source>Images (PNG)</source>
        <translation>Imágenes (PNG)</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/recording_bars.py" line="189"/>
        <source>Images (TIFF, fast)</source>
        <translation>Imágenes (TIFF, rápido)</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/recording_bars.py" line="144"/>
        <source>Stop recording</source>
        <translation>Dejar de grabar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/recording_bars.py" line="151"/>
        <source>{0} frames</source>
        <translation>{0} imágenes</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/recording_bars.py" line="154"/>
        <source>{0} dropped</source>
        <translation>{0} descartadas</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/recording_bars.py" line="158"/>
        <source>{0} free</source>
        <translation>{0} libres</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/recording_bars.py" line="179"/>
        <source>Play {0} in place of the camera</source>
        <translation>Reproducir {0} en lugar de la cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/recording_bars.py" line="187"/>
        <source>Movie, lossless up to 16 bits (FFV1)</source>
        <translation>Vídeo sin pérdidas de hasta 16 bits (FFV1)</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/recording_bars.py" line="151"/>
        <source>1 frame</source>
        <translation>1 imagen</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/recording_bars.py" line="156"/>
        <source>first image of {0}</source>
        <translation>primera imagen de {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/recording_bars.py" line="154"/>
        <source>1 dropped</source>
        <translation>1 descartada</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/recording_bars.py" line="190"/>
        <source>One TIFF with pages</source>
        <translation>Un TIFF con páginas</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/recording_bars.py" line="191"/>
        <source>NumPy array (.npy)</source>
        <translation>Matriz de NumPy (.npy)</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/recording_bars.py" line="160"/>
        <source>for {0}</source>
        <translation>para {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/recording_bars.py" line="183"/>
        <source>All raw data (MCAP)</source>
        <translation>Todos los datos en bruto (MCAP)</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/recording_bars.py" line="184"/>
        <source>All raw data (ROS 2 bag)</source>
        <translation>Todos los datos en bruto (bag de ROS 2)</translation>
    </message>
</context>
<context>
    <name>RecordingController</name>
    <message>
        <location filename="../../grabbergui/ui/controllers/recording.py" line="123"/>
        <source>Folder for recordings</source>
        <translation>Carpeta para grabaciones</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/recording.py" line="93"/>
        <source>Recording</source>
        <translation>Grabación</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/recording.py" line="87"/>
        <source>Closing ends the recording; what was recorded so far is kept.</source>
        <translation>Al cerrar termina la grabación; lo grabado hasta ahora se conserva.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/recording.py" line="94"/>
        <source>Stop recording and close</source>
        <translation>Detener la grabación y cerrar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/recording.py" line="95"/>
        <source>Continue recording</source>
        <translation>Seguir grabando</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/recording.py" line="87"/>
        <source>Being recorded: {0}</source>
        <translation>Se está grabando: {0}</translation>
    </message>
</context>
<context>
    <name>RegionController</name>
    <message>
        <location filename="../../grabbergui/ui/controllers/tuning.py" line="239"/>
        <source>the region could not be changed: {0}</source>
        <translation>no se pudo cambiar la región: {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/tuning.py" line="232"/>
        <source>Region of the sensor</source>
        <translation>Región del sensor</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/tuning.py" line="184"/>
        <source>there is no image yet to draw on; start the camera first, or write OffsetX, OffsetY, Width and Height</source>
        <translation>todavía no hay imagen sobre la que dibujar; inicie primero la cámara, o escriba OffsetX, OffsetY, Width y Height</translation>
    </message>
</context>
<context>
    <name>Remote</name>
    <message>
        <location filename="../../grabbergui/models/remote_source.py" line="40"/>
        <source>{0} from {1}</source>
        <translation>{0} desde {1}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/remote_source.py" line="41"/>
        <source>A remote camera: {0} over {1}.</source>
        <translation>Una cámara remota: {0} por {1}.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/remote_source.py" line="50"/>
        <source>under {0} s old</source>
        <translation>hace menos de {0} s</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/remote_source.py" line="51"/>
        <source>{0} s old</source>
        <translation>hace {0} s</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/remote_source.py" line="42"/>
        <source>The shown image is {0}.</source>
        <translation>Imagen mostrada: {0}.</translation>
    </message>
</context>
<context>
    <name>ReportController</name>
    <message>
        <location filename="../../grabbergui/ui/controllers/report.py" line="94"/>
        <source>Save the report</source>
        <translation>Guardar el informe</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/report.py" line="94"/>
        <source>Reports (*.zip)</source>
        <translation>Informes (*.zip)</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/report.py" line="100"/>
        <source>{0} cannot be written: {1}</source>
        <translation>No se puede escribir {0}: {1}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/report.py" line="102"/>
        <source>Saved the report to {0}</source>
        <translation>Informe guardado en {0}</translation>
    </message>
</context>
<context>
    <name>ReportDialog</name>
    <message>
        <location filename="../../grabbergui/ui/views/report_dialog.py" line="25"/>
        <source>Report this camera</source>
        <translation>Informe de esta cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/report_dialog.py" line="26"/>
        <source>Asking the camera and this computer…</source>
        <translation>Consultando la cámara y este ordenador…</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/report_dialog.py" line="30"/>
        <source>Contents of the report</source>
        <translation>Contenido del informe</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/report_dialog.py" line="31"/>
        <source>Keep &amp;names, serial numbers and addresses</source>
        <translation>Conservar &amp;nombres, números de serie y direcciones</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/report_dialog.py" line="32"/>
        <source>Otherwise stand-ins replace them, also in registers and log</source>
        <translation>Si no, se sustituyen por otros, también en registros y en el log</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/report_dialog.py" line="33"/>
        <source>With the &amp;pixels of some frames</source>
        <translation>Con los &amp;píxeles de algunos fotogramas</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/report_dialog.py" line="50"/>
        <source>The file will contain:</source>
        <translation>El archivo contendrá:</translation>
    </message>
</context>
<context>
    <name>RigController</name>
    <message>
        <location filename="../../grabbergui/rig/ui/controller.py" line="164"/>
        <source>Written to the cameras and into {0}.</source>
        <translation>Escrito en las cámaras y en {0}.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/controller.py" line="180"/>
        <source>{0} has no such values any more; the cameras keep theirs.</source>
        <translation>{0} ya no tiene esos valores; las cámaras conservan los suyos.</translation>
    </message>
</context>
<context>
    <name>RigDialog</name>
    <message>
        <location filename="../../grabbergui/rig/ui/forms/rig_dialog.ui" line="6"/>
        <source>Rig</source>
        <translation>Grupo de cámaras</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/forms/rig_dialog.ui" line="10"/>
        <source>Sets of frames</source>
        <translation>Conjuntos de imágenes</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/forms/rig_dialog.ui" line="17"/>
        <source>Skew of the sets</source>
        <translation>Desfase de los conjuntos</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/forms/rig_dialog.ui" line="24"/>
        <source>Skew of the recent sets</source>
        <translation>Desfase de los conjuntos recientes</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/forms/rig_dialog.ui" line="30"/>
        <source>Cameras of the rig</source>
        <translation>Cámaras del grupo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/rig_dialog.py" line="93"/>
        <source>Camera</source>
        <translation>Cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/forms/rig_dialog.ui" line="33"/>
        <source>Frames</source>
        <translation>Imágenes</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/forms/rig_dialog.ui" line="34"/>
        <source>Missing in sets</source>
        <translation>Faltan en conjuntos</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/forms/rig_dialog.ui" line="35"/>
        <source>Clock</source>
        <translation>Reloj</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/forms/rig_dialog.ui" line="50"/>
        <source>Budget of the link</source>
        <translation>Presupuesto del enlace</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/forms/rig_dialog.ui" line="42"/>
        <source>&amp;Compute again</source>
        <translation>&amp;Calcular de nuevo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/forms/rig_dialog.ui" line="43"/>
        <source>&amp;Apply</source>
        <translation>&amp;Aplicar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/forms/rig_dialog.ui" line="43"/>
        <source>Write the values of the column “Set” to the cameras and into the rig's file; Undo takes them back</source>
        <translation>Escribir los valores de la columna «Ajuste» en las cámaras y en el archivo del grupo; Deshacer los retira</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/forms/rig_dialog.ui" line="44"/>
        <source>&amp;Remove from the file</source>
        <translation>&amp;Quitar del archivo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/forms/rig_dialog.ui" line="44"/>
        <source>Take these values out of the rig&apos;s file; the cameras keep theirs</source>
        <translation>Quitar estos valores del archivo del grupo; las cámaras conservan los suyos</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/forms/rig_dialog.ui" line="62"/>
        <source>Close</source>
        <translation>Cerrar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/rig_dialog.py" line="54"/>
        <source>Rig {0}</source>
        <translation>Grupo {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/rig_dialog.py" line="62"/>
        <source>Skew {0:.1f} µs (median) · {1:.1f} µs (p99) · {2:.1f} µs (worst)</source>
        <translation>Desfase {0:.1f} µs (mediana) · {1:.1f} µs (p99) · {2:.1f} µs (peor)</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/rig_dialog.py" line="74"/>
        <source>These cameras are on no link that they share.</source>
        <translation>Estas cámaras no comparten ningún enlace.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/rig_dialog.py" line="80"/>
        <source>All frames fit into the link.</source>
        <translation>Todas las imágenes caben en el enlace.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/rig_dialog.py" line="94"/>
        <source>Frame</source>
        <translation>Imagen</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/rig_dialog.py" line="95"/>
        <source>Rate</source>
        <translation>Frecuencia</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/rig_dialog.py" line="96"/>
        <source>Packet</source>
        <translation>Paquete</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/rig_dialog.py" line="97"/>
        <source>Needs</source>
        <translation>Necesita</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/rig_dialog.py" line="98"/>
        <source>Share</source>
        <translation>Compartir</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/rig_dialog.py" line="99"/>
        <source>Frame takes</source>
        <translation>Dura</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/rig_dialog.py" line="100"/>
        <source>Set</source>
        <translation>Ajuste</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/rig_dialog.py" line="105"/>
        <source>sets before the newest</source>
        <translation>conjuntos antes del último</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/rig_dialog.py" line="105"/>
        <source>µs</source>
        <translation>µs</translation>
    </message>
    <message>
        <location filename="../../grabbergui/rig/ui/rig_dialog.py" line="59"/>
        <source>Complete sets: {0} · late: {1} · incomplete: {2}</source>
        <translation>Conjuntos completos: {0} · tardíos: {1} · incompletos: {2}</translation>
    </message>
</context>
<context>
    <name>RobotView</name>
    <message>
        <location filename="../../grabbergui/servo/ui/robot_view.py" line="106"/>
        <source>Drag to rotate, wheel to zoom, double-click to reset</source>
        <translation>Arrastrar para girar, rueda para acercarse, doble clic para volver</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/robot_view.py" line="161"/>
        <source>The robot has not answered yet</source>
        <translation>El robot todavía no ha respondido</translation>
    </message>
</context>
<context>
    <name>ScaleBar</name>
    <message>
        <location filename="../../grabbergui/ui/widgets/scale_bar.py" line="51"/>
        <source>Scale of the colours: {0}</source>
        <translation>Escala de los colores: {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/widgets/scale_bar.py" line="98"/>
        <source>no data</source>
        <translation>sin datos</translation>
    </message>
</context>
<context>
    <name>Section</name>
    <message>
        <location filename="../../grabbergui/ui/views/feature_panel.py" line="196"/>
        <source>Expand all</source>
        <translation>Expandir todo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/feature_panel.py" line="197"/>
        <source>Collapse all</source>
        <translation>Contraer todo</translation>
    </message>
</context>
<context>
    <name>ServoController</name>
    <message>
        <location filename="../../grabbergui/servo/ui/servo_controller.py" line="128"/>
        <source>The camera is not calibrated, a field of view is assumed: distances are rough</source>
        <translation>La cámara no está calibrada, se supone un campo de visión: las distancias son aproximadas</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/servo_controller.py" line="128"/>
        <source>Calibrate…</source>
        <translation>Calibrar…</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/servo_controller.py" line="162"/>
        <source>{0} is in use; Start lets the robot move</source>
        <translation>{0} está en uso; Iniciar permite que el robot se mueva</translation>
    </message>
</context>
<context>
    <name>ServoWindow</name>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/servo.ui" line="6"/>
        <source>Visual servoing</source>
        <translation>Control visual</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/servo.ui" line="24"/>
        <source>The states of the loop; the current one is lit</source>
        <translation>Los estados del bucle; el actual está iluminado</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/servo.ui" line="43"/>
        <source>S&amp;tart</source>
        <translation>&amp;Iniciar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/servo.ui" line="50"/>
        <source>EMERGENCY STOP</source>
        <translation>PARADA DE EMERGENCIA</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/servo.ui" line="51"/>
        <source>Stops the robot at once (Space, Escape)</source>
        <translation>Para el robot de inmediato (Espacio, Escape)</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/servo.ui" line="81"/>
        <source>History of states</source>
        <translation>Historial de estados</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/servo.ui" line="87"/>
        <source>Time</source>
        <translation>Hora</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/servo.ui" line="88"/>
        <source>State</source>
        <translation>Estado</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/servo.ui" line="89"/>
        <source>Why</source>
        <translation>Por qué</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/servo.ui" line="95"/>
        <source>&amp;Head gain</source>
        <translation>Ganancia de la &amp;cabeza</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/servo.ui" line="98"/>
        <source>Speed of the head for each radian off centre</source>
        <translation>Velocidad de la cabeza por cada radián de desviación</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/servo.ui" line="114"/>
        <source> /s</source>
        <translation> /s</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/servo.ui" line="103"/>
        <source>Head at &amp;most</source>
        <translation>Cabeza como &amp;máximo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/servo.ui" line="106"/>
        <source> °/s</source>
        <translation> °/s</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/servo.ui" line="110"/>
        <source>&amp;Arm gain</source>
        <translation>Ganancia del &amp;brazo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/servo.ui" line="113"/>
        <source>Speed of the hand for each metre and radian of error</source>
        <translation>Velocidad de la mano por cada metro y radián de error</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/servo.ui" line="118"/>
        <source>Han&amp;d at most</source>
        <translation>Mano como má&amp;ximo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/servo.ui" line="121"/>
        <source> mm/s</source>
        <translation> mm/s</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/servo.ui" line="125"/>
        <source>&amp;Rate</source>
        <translation>&amp;Frecuencia</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/servo.ui" line="128"/>
        <source>Commands per second</source>
        <translation>Órdenes por segundo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/servo.ui" line="129"/>
        <source> Hz</source>
        <translation> Hz</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/servo.ui" line="70"/>
        <source>Live image</source>
        <translation>Imagen en directo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/servo.ui" line="154"/>
        <source>The robot in space</source>
        <translation>El robot en el espacio</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/servo.ui" line="44"/>
        <source>Let the robot move</source>
        <translation>Deja que el robot se mueva</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/servo_window.py" line="241"/>
        <source>Hand to goal, mm</source>
        <translation>Mano a objetivo, mm</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/servo_window.py" line="242"/>
        <source>Hand to goal, °</source>
        <translation>Mano a objetivo, °</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/servo_window.py" line="243"/>
        <source>Velocity of the hand, mm/s</source>
        <translation>Velocidad de la mano, mm/s</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/servo_window.py" line="244"/>
        <source>Rotation of the hand, °/s</source>
        <translation>Giro de la mano, °/s</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/servo.ui" line="133"/>
        <source>S&amp;peed</source>
        <translation>&amp;Velocidad</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/servo.ui" line="136"/>
        <source>All motion is slowed down to this share of its speed</source>
        <translation>Todo movimiento se frena a esta parte de su velocidad</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/servo.ui" line="137"/>
        <source> %</source>
        <translation> %</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/servo.ui" line="37"/>
        <source>Hand–&amp;eye…</source>
        <translation>Mano-&amp;ojo…</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/servo.ui" line="38"/>
        <source>Calibrate where the camera is mounted: the loop ends, and the robot looks at a board from several poses</source>
        <translation>Calibrar dónde está la cámara: el lazo termina y el robot mira un tablero desde varias posturas</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/forms/servo.ui" line="31"/>
        <source>What is measured of the hand, and the limits that it keeps</source>
        <translation>Lo que se mide de la mano y los límites que respeta</translation>
    </message>
</context>
<context>
    <name>Servoing</name>
    <message>
        <location filename="../../grabbergui/servo/models/servoing.py" line="303"/>
        <source>searching</source>
        <translation>buscando</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/servoing.py" line="304"/>
        <source>centring</source>
        <translation>centrando</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/servoing.py" line="305"/>
        <source>waiting for the marker</source>
        <translation>esperando el marcador</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/servoing.py" line="306"/>
        <source>approaching</source>
        <translation>acercándose</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/servoing.py" line="308"/>
        <source>reached</source>
        <translation>alcanzado</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/servoing.py" line="309"/>
        <source>stuck</source>
        <translation>atascado</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/servoing.py" line="310"/>
        <source>lost</source>
        <translation>perdido</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/servoing.py" line="311"/>
        <source>stopped</source>
        <translation>parado</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/servoing.py" line="307"/>
        <source>following</source>
        <translation>siguiendo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/models/servoing.py" line="279"/>
        <source>Hand: {0} of {1} mm/s, {2} of {3} °/s, {4} mm inside its workspace</source>
        <translation>Mano: {0} de {1} mm/s, {2} de {3} °/s, {4} mm dentro de su espacio de trabajo</translation>
    </message>
</context>
<context>
    <name>Settings</name>
    <message>
        <location filename="../../grabbergui/models/settings/loading.py" line="156"/>
        <source>the stream does not start again: {0}</source>
        <translation>la captura no vuelve a arrancar: {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/settings/loading.py" line="262"/>
        <source>cancelled</source>
        <translation>cancelado</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/settings/loading.py" line="308"/>
        <source>{0} sets it</source>
        <translation>lo fija {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/settings/loading.py" line="312"/>
        <source>{0} is off in the set; writing this would turn it on</source>
        <translation>{0} está apagado en el archivo; escribir esto lo encendería</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/settings/loading.py" line="280"/>
        <source>it is a command; loading settings runs none</source>
        <translation>es una orden; al cargar ajustes no se ejecuta ninguna</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/settings/loading.py" line="239"/>
        <source>the camera reports {0}</source>
        <translation>la cámara indica {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/settings/loading.py" line="170"/>
        <source>interrupted: {0}</source>
        <translation>interrumpido: {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/settings/loading.py" line="232"/>
        <source>the camera was lost during this write: it may have either value</source>
        <translation>la cámara se perdió durante esta escritura: puede tener cualquiera de los dos valores</translation>
    </message>
</context>
<context>
    <name>SettingsDifference</name>
    <message>
        <location filename="../../grabbergui/ui/forms/settings_difference.ui" line="6"/>
        <source>Compare settings</source>
        <translation>Comparar ajustes</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/settings_difference.ui" line="15"/>
        <source>Differences</source>
        <translation>Diferencias</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/settings_dialogs.py" line="177"/>
        <source>Setting</source>
        <translation>Ajuste</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/settings_difference.ui" line="29"/>
        <source>Close</source>
        <translation>Cerrar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/settings_dialogs.py" line="168"/>
        <source>There is no difference.</source>
        <translation>No hay ninguna diferencia.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/settings_dialogs.py" line="179"/>
        <source>Set as in {0}</source>
        <translation>Ajustar como en {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/settings_dialogs.py" line="204"/>
        <source>(not in this file)</source>
        <translation>(no está)</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/settings_dialogs.py" line="168"/>
        <source>1 setting differs. If it is ticked, it can be set on the camera.</source>
        <translation>1 ajuste difiere. Si está marcado, se puede ajustar en la cámara.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/settings_dialogs.py" line="168"/>
        <source>{0} settings differ. Those that are ticked can be set on the camera.</source>
        <translation>{0} ajustes difieren. Los marcados se pueden ajustar en la cámara.</translation>
    </message>
</context>
<context>
    <name>SettingsFilesController</name>
    <message>
        <location filename="../../grabbergui/ui/controllers/settings.py" line="55"/>
        <source>Settings (*.yaml *.yml *.pfs *.txt);;All files (*)</source>
        <translation>Ajustes (*.yaml *.yml *.pfs *.txt);;Todos los archivos (*)</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/settings.py" line="90"/>
        <source>Save settings</source>
        <translation>Guardar ajustes</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/settings.py" line="95"/>
        <source>Load settings</source>
        <translation>Cargar ajustes</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/settings.py" line="100"/>
        <source>Compare the camera with settings</source>
        <translation>Comparar la cámara con unos ajustes</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/settings.py" line="167"/>
        <source>Camera and {0}</source>
        <translation>Cámara y {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/settings.py" line="154"/>
        <source>Loaded {0}</source>
        <translation>Cargado {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/settings.py" line="202"/>
        <source>Rolled back: {0}</source>
        <translation>Revertido: {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/settings.py" line="105"/>
        <source>First settings</source>
        <translation>Primeros ajustes</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/settings.py" line="105"/>
        <source>Second settings</source>
        <translation>Segundos ajustes</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/settings.py" line="128"/>
        <source>Saving settings</source>
        <translation>Guardando ajustes</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/settings.py" line="156"/>
        <source>Loading settings</source>
        <translation>Cargando ajustes</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/settings.py" line="169"/>
        <source>Comparing settings</source>
        <translation>Comparando ajustes</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/settings.py" line="203"/>
        <source>Rolling back</source>
        <translation>Revirtiendo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/settings.py" line="125"/>
        <source>1 setting</source>
        <translation>1 ajuste</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/settings.py" line="125"/>
        <source>{0} settings</source>
        <translation>{0} ajustes</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/settings.py" line="126"/>
        <source>Saved {0} to {1}</source>
        <translation>Guardado: {0} en {1}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/settings.py" line="198"/>
        <source>Not rolled back: {0}</source>
        <translation>No revertido: {0}</translation>
    </message>
</context>
<context>
    <name>SettingsReport</name>
    <message>
        <location filename="../../grabbergui/ui/forms/settings_report.ui" line="15"/>
        <source>Settings</source>
        <translation>Ajustes</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/settings_report.ui" line="19"/>
        <source>Setting</source>
        <translation>Ajuste</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/settings_report.ui" line="21"/>
        <source>File</source>
        <translation>Archivo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/settings_report.ui" line="24"/>
        <source>Why</source>
        <translation>Por qué</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/settings_report.ui" line="31"/>
        <source>Show &amp;equal settings</source>
        <translation>Mostrar lo que era i&amp;gual</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/settings_report.ui" line="35"/>
        <source>&amp;Apply to the camera</source>
        <translation>&amp;Aplicar a la cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/settings_report.ui" line="36"/>
        <source>&amp;Roll back</source>
        <translation>&amp;Revertir</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/settings_report.ui" line="37"/>
        <source>Close</source>
        <translation>Cerrar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/settings_dialogs.py" line="101"/>
        <source>written</source>
        <translation>escrito</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/settings_dialogs.py" line="102"/>
        <source>equal</source>
        <translation>igual</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/settings_dialogs.py" line="105"/>
        <source>refused</source>
        <translation>rechazado</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/settings_dialogs.py" line="107"/>
        <source>left alone</source>
        <translation>sin tocar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/settings_dialogs.py" line="108"/>
        <source>unknown</source>
        <translation>desconocido</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/settings_dialogs.py" line="109"/>
        <source>cancelled</source>
        <translation>cancelado</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/settings_report.ui" line="23"/>
        <source>Result</source>
        <translation>Resultado</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/settings_dialogs.py" line="97"/>
        <source>Nothing to do</source>
        <translation>Nada que hacer</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/settings_dialogs.py" line="106"/>
        <source>came out different</source>
        <translation>quedó distinto</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/settings_dialogs.py" line="103"/>
        <source>would be written</source>
        <translation>por escribir</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/settings_dialogs.py" line="96"/>
        <source>not a setting</source>
        <translation>no es un ajuste</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/settings_dialogs.py" line="104"/>
        <source>depends on the others</source>
        <translation>depende de los demás</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/settings_dialogs.py" line="63"/>
        <source>Settings already written are restored when the camera is back, the others are not</source>
        <translation>Lo escrito se vuelve a ajustar cuando la cámara regrese; el resto no</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/settings_dialogs.py" line="110"/>
        <source>not written</source>
        <translation>no escrito</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/settings_report.ui" line="20"/>
        <source>Before</source>
        <translation>Antes</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/settings_report.ui" line="22"/>
        <source>Now</source>
        <translation>Ahora</translation>
    </message>
</context>
<context>
    <name>ShareDialog</name>
    <message>
        <location filename="../../grabbergui/ui/forms/share_dialog.ui" line="6"/>
        <source>Share the camera</source>
        <translation>Compartir la cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/share_dialog.ui" line="20"/>
        <source>Others receive images and values, and cannot change anything</source>
        <translation>Los demás reciben imágenes y valores, y no pueden cambiar nada</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/share_dialog.ui" line="21"/>
        <source>Others may only &amp;look</source>
        <translation>Los demás so&amp;lo pueden mirar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/share_dialog.ui" line="28"/>
        <source>&amp;Connected</source>
        <translation>C&amp;onectados</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/share_dialog.ui" line="35"/>
        <source>Connected programs</source>
        <translation>Programas conectados</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/share_dialog.ui" line="38"/>
        <source>Program</source>
        <translation>Programa</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/share_dialog.ui" line="39"/>
        <source>Takes</source>
        <translation>Recibe</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/share_dialog.ui" line="40"/>
        <source>From</source>
        <translation>Desde</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/share_dialog.ui" line="41"/>
        <source>Port or topic</source>
        <translation>Puerto o tema</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/share_dialog.ui" line="46"/>
        <source>C&amp;hanged by others</source>
        <translation>Ca&amp;mbiado por otros</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/share_dialog.ui" line="53"/>
        <source>Changes by others</source>
        <translation>Cambios de otros</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/share_dialog.ui" line="62"/>
        <source>Close this dialog; the camera stays shared</source>
        <translation>Cerrar este diálogo; la cámara sigue compartida</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/share_dialog.ui" line="63"/>
        <source>Close</source>
        <translation>Cerrar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/share_dialog.py" line="169"/>
        <source>{0}: others see its image and settings while this window is open.</source>
        <translation>{0}: los demás ven su imagen y sus ajustes mientras esta ventana esté abierta.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/share_dialog.py" line="172"/>
        <source>No camera is open.</source>
        <translation>No hay ninguna cámara abierta.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/share_dialog.py" line="218"/>
        <source>no images</source>
        <translation>sin imágenes</translation>
    </message>
</context>
<context>
    <name>ShareNetworkBox</name>
    <message>
        <location filename="../../grabbergui/ui/forms/share_network.ui" line="9"/>
        <source>Name</source>
        <translation>Nombre</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/share_dialog.py" line="102"/>
        <source>Share</source>
        <translation>Compartir</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/share_network.ui" line="22"/>
        <source>Name server</source>
        <translation>Servidor de nombres</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/share_network.ui" line="28"/>
        <source>HOST:PORT of the YARP name server; empty: the one that YARP is configured for</source>
        <translation>EQUIPO:PUERTO del servidor de nombres de YARP; vacío: el que YARP tiene configurado</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/share_network.ui" line="29"/>
        <source>as YARP is configured</source>
        <translation>según la configuración de YARP</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/share_network.ui" line="34"/>
        <source>Run a name server in this window: for this computer, or at the address of this computer that you write. It ends with the window</source>
        <translation>Ejecutar un servidor de nombres en esta ventana: para este ordenador, o en la dirección de este ordenador que escriba. Termina con la ventana</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/share_network.ui" line="35"/>
        <source>Run it here</source>
        <translation>Ejecutarlo aquí</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/share_network.ui" line="40"/>
        <source>Domain</source>
        <translation>Dominio</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/share_network.ui" line="46"/>
        <source>Only nodes of the same domain see the camera</source>
        <translation>Solo los nodos del mismo dominio ven la cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/share_dialog.py" line="63"/>
        <source>as ROS_DOMAIN_ID</source>
        <translation>según ROS_DOMAIN_ID</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/share_dialog.py" line="75"/>
        <source>The port&apos;s name</source>
        <translation>Nombre del puerto</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/share_dialog.py" line="75"/>
        <source>The node&apos;s name, which prefixes its topics</source>
        <translation>Nombre del nodo, que precede a sus temas</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/share_dialog.py" line="102"/>
        <source>Stop</source>
        <translation>Detener</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/share_dialog.py" line="114"/>
        <source>Run a name server here</source>
        <translation>Ejecutar aquí un servidor de nombres</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/share_dialog.py" line="116"/>
        <source>Copy the command</source>
        <translation>Copiar la orden</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/share_dialog.py" line="122"/>
        <source>Starting…</source>
        <translation>Iniciando…</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/share_dialog.py" line="124"/>
        <source>Stopping…</source>
        <translation>Deteniendo…</translation>
    </message>
</context>
<context>
    <name>Sharing</name>
    <message>
        <location filename="../../grabbergui/models/share.py" line="112"/>
        <source>{0:.1f} images/s · {1:.1f} MB/s</source>
        <translation>{0:.1f} imágenes/s · {1:.1f} MB/s</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/share.py" line="244"/>
        <source>no YARP name server answers at {0}</source>
        <translation>ningún servidor de nombres de YARP responde en {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/share.py" line="247"/>
        <source>ROS 2 is not installed; this command installs it: {0}</source>
        <translation>ROS 2 no está instalado; esta orden lo instala: {0}</translation>
    </message>
</context>
<context>
    <name>SharingController</name>
    <message>
        <location filename="../../grabbergui/ui/controllers/sharing.py" line="86"/>
        <source>{0} and {1} more</source>
        <translation>{0} y {1} más</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/sharing.py" line="87"/>
        <source>Others read this camera: {0}</source>
        <translation>Otros leen esta cámara: {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/sharing.py" line="87"/>
        <source>They receive no more images.</source>
        <translation>Dejarán de recibir imágenes.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/sharing.py" line="93"/>
        <source>Share</source>
        <translation>Compartir</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/sharing.py" line="94"/>
        <source>Stop sharing</source>
        <translation>Dejar de compartir</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/sharing.py" line="95"/>
        <source>Keep sharing</source>
        <translation>Seguir compartiendo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/sharing.py" line="185"/>
        <source>Share this camera with other programs and computers</source>
        <translation>Compartir esta cámara con otros programas y ordenadores</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/sharing.py" line="188"/>
        <source>Shared ({0})</source>
        <translation>Compartida ({0})</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/sharing.py" line="189"/>
        <source>Shared on {0}</source>
        <translation>Compartida en {0}</translation>
    </message>
</context>
<context>
    <name>ShortcutsDialog</name>
    <message>
        <location filename="../../grabbergui/ui/forms/shortcuts_dialog.ui" line="6"/>
        <source>Keyboard and mouse</source>
        <translation>Teclado y ratón</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/shortcuts_dialog.ui" line="52"/>
        <source>Close</source>
        <translation>Cerrar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/shortcuts_dialog.ui" line="33"/>
        <source>Over the image the wheel zooms, dragging moves it, and a double click fits it or shows it 1:1. A slider takes the wheel, the arrow keys, Page Up and Down, Home and End; with Shift it goes a tenth as far, with Ctrl ten times as far. Esc cancels what is being drawn or typed. Letters work while the image has the focus: Enter gives it back.</source>
        <translation>Sobre la imagen la rueda amplía, arrastrar la mueve y un doble clic la ajusta o la muestra 1:1. Un deslizador acepta la rueda, las flechas, Re Pág y Av Pág, Inicio y Fin; con Mayús avanza una décima parte, con Ctrl diez veces más. Esc abandona lo que se dibuja o escribe. Las letras actúan mientras la imagen tiene el foco: Intro se lo devuelve.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/help_views.py" line="158"/>
        <source>Shift</source>
        <translation>Mayús</translation>
    </message>
</context>
<context>
    <name>SnapshotKindController</name>
    <message>
        <location filename="../../grabbergui/ui/controllers/snapshot_kind.py" line="19"/>
        <source>PNG, or TIFF above 8 bits</source>
        <translation>PNG, o TIFF con más de 8 bits</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/snapshot_kind.py" line="20"/>
        <source>TIFF, the sensor&apos;s values</source>
        <translation>TIFF, los valores del sensor</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/snapshot_kind.py" line="21"/>
        <source>Raw payload with a description</source>
        <translation>Datos sin procesar con una descripción</translation>
    </message>
</context>
<context>
    <name>SourceListView</name>
    <message>
        <location filename="../../grabbergui/ui/forms/source_list.ui" line="18"/>
        <source>A source by its address; Enter connects. Also gige:&lt;serial&gt; or gige:&lt;MAC&gt;.</source>
        <translation>Una fuente por su dirección; Intro conecta. También gige:&lt;n.º de serie&gt; o gige:&lt;MAC&gt;.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/source_list.ui" line="19"/>
        <source>Address of a source</source>
        <translation>Dirección de una fuente</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/source_list.ui" line="20"/>
        <source>gige:192.168.0.10</source>
        <translation>gige:192.168.0.10</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/source_list.ui" line="26"/>
        <source>Search again now (F5)</source>
        <translation>Buscar de nuevo ahora (F5)</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/source_list.ui" line="27"/>
        <source>Search for sources again</source>
        <translation>Buscar fuentes de nuevo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/source_list.ui" line="28"/>
        <source>Search</source>
        <translation>Buscar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/source_list.ui" line="29"/>
        <source>F5</source>
        <translation>F5</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/source_list.ui" line="57"/>
        <source>Sources found; a double click or Enter connects</source>
        <translation>Fuentes halladas; un doble clic o Intro conecta</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/source_list.ui" line="58"/>
        <source>Sources found</source>
        <translation>Fuentes halladas</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/source_list.ui" line="69"/>
        <source>A real camera appears here once it is plugged in. If it does not, type its address above.</source>
        <translation>Una cámara real aparece aquí cuando se conecta. Si no aparece, escriba arriba su dirección.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/source_list.ui" line="89"/>
        <source>Connect to the chosen source, or disconnect</source>
        <translation>Conectar con la fuente elegida o soltarla</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/source_list.py" line="315"/>
        <source>Connect</source>
        <translation>Conectar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/source_list.ui" line="96"/>
        <source>Open the chosen source in a tile; the current one stays open</source>
        <translation>Abrir la fuente elegida en una miniatura y dejar la otra como está</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/source_list.py" line="268"/>
        <source>Open beside</source>
        <translation>Abrir al lado</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/source_list.py" line="277"/>
        <source>Forget</source>
        <translation>Olvidar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/source_list.py" line="315"/>
        <source>Disconnect</source>
        <translation>Desconectar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/source_list.py" line="315"/>
        <source>Show</source>
        <translation>Mostrar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/source_list.py" line="327"/>
        <source>source</source>
        <translation>fuente</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/source_list.py" line="328"/>
        <source>vendor</source>
        <translation>fabricante</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/source_list.py" line="329"/>
        <source>model</source>
        <translation>modelo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/source_list.py" line="330"/>
        <source>name</source>
        <translation>nombre</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/source_list.py" line="331"/>
        <source>serial</source>
        <translation>n.º de serie</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/source_list.py" line="332"/>
        <source>address</source>
        <translation>dirección</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/source_list.py" line="333"/>
        <source>version</source>
        <translation>versión</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/source_list.py" line="334"/>
        <source>seen on</source>
        <translation>vista en</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/source_list.py" line="335"/>
        <source>note</source>
        <translation>nota</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/source_list.py" line="266"/>
        <source>Connect without starting</source>
        <translation>Conectar sin iniciar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/source_list.py" line="270"/>
        <source>Connect with a description file…</source>
        <translation>Conectar con un archivo de descripción…</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/source_list.py" line="275"/>
        <source>IP address…</source>
        <translation>Dirección IP…</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/source_list.py" line="336"/>
        <source>did not open</source>
        <translation>no se abrió</translation>
    </message>
</context>
<context>
    <name>Sources</name>
    <message>
        <location filename="../../grabbergui/models/sources.py" line="69"/>
        <source>serial {0}</source>
        <translation>n.º de serie {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/sources.py" line="60"/>
        <source>lost, reconnecting</source>
        <translation>perdida, reconectando</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/sources.py" line="62"/>
        <source>connected</source>
        <translation>conectada</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/sources.py" line="66"/>
        <source>added by hand</source>
        <translation>añadida a mano</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/sources.py" line="77"/>
        <source>Simulated</source>
        <translation>Simulada</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/sources.py" line="78"/>
        <source>File</source>
        <translation>Archivo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/sources.py" line="64"/>
        <source>did not open</source>
        <translation>no se abrió</translation>
    </message>
</context>
<context>
    <name>SourcesController</name>
    <message>
        <location filename="../../grabbergui/ui/controllers/sources.py" line="194"/>
        <source>Connecting</source>
        <translation>Conectando</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/sources.py" line="151"/>
        <source>GenICam descriptions (*.xml *.zip)</source>
        <translation>Descripciones GenICam (*.xml *.zip)</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/sources.py" line="152"/>
        <source>Description of this camera</source>
        <translation>Descripción de esta cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/sources.py" line="113"/>
        <source>The other program receives no more images: a recording there ends.</source>
        <translation>El otro programa deja de recibir imágenes: una grabación allí termina.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/sources.py" line="115"/>
        <source>It is recording {0}; the recording ends.</source>
        <translation>Está grabando {0}; la grabación termina.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/sources.py" line="116"/>
        <source>another program</source>
        <translation>otro programa</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/sources.py" line="117"/>
        <source>Take control of {0} from {1}?</source>
        <translation>¿Tomar el control de {0} a {1}?</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/sources.py" line="123"/>
        <source>Take control</source>
        <translation>Tomar el control</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/sources.py" line="124"/>
        <source>Leave it there</source>
        <translation>Dejarlo allí</translation>
    </message>
</context>
<context>
    <name>StateStrip</name>
    <message>
        <location filename="../../grabbergui/servo/ui/servo_window.py" line="107"/>
        <source>waiting</source>
        <translation>esperando</translation>
    </message>
</context>
<context>
    <name>Status</name>
    <message>
        <location filename="../../grabbergui/models/status.py" line="38"/>
        <source>Not connected</source>
        <translation>Sin conexión</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/status.py" line="39"/>
        <source>Connecting</source>
        <translation>Conectando</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/status.py" line="40"/>
        <source>Stopped</source>
        <translation>Parada</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/status.py" line="41"/>
        <source>Read only</source>
        <translation>Solo lectura</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/status.py" line="42"/>
        <source>Starting</source>
        <translation>Arrancando</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/status.py" line="43"/>
        <source>Live</source>
        <translation>En directo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/status.py" line="44"/>
        <source>Playing</source>
        <translation>Reproduciendo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/status.py" line="45"/>
        <source>Paused</source>
        <translation>En pausa</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/status.py" line="46"/>
        <source>Waiting for trigger</source>
        <translation>Esperando disparo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/status.py" line="47"/>
        <source>No frame for {0:.0f} s</source>
        <translation>Sin imagen desde hace {0:.0f} s</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/status.py" line="48"/>
        <source>Lost for {0:.0f} s</source>
        <translation>Perdida desde hace {0:.0f} s</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/status.py" line="156"/>
        <source>{0} fps</source>
        <translation>{0} im/s</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/status.py" line="158"/>
        <source>{0}, losing frames</source>
        <translation>{0}, pierde imágenes</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/status.py" line="167"/>
        <source>● Recording</source>
        <translation>● Grabando</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/status.py" line="169"/>
        <source>connection lost</source>
        <translation>conexión perdida</translation>
    </message>
</context>
<context>
    <name>StatusController</name>
    <message>
        <location filename="../../grabbergui/ui/controllers/status.py" line="106"/>
        <source>The camera does not answer; its last known settings are shown until it is back.</source>
        <translation>La cámara no responde; hasta que vuelva se muestra lo último que se ajustó.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/status.py" line="150"/>
        <source>Nothing is connected.</source>
        <translation>No hay nada conectado.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/status.py" line="156"/>
        <source>Connecting to {0} …</source>
        <translation>Conectando con {0} …</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/status.py" line="158"/>
        <source>Waiting for a trigger</source>
        <translation>Esperando un disparo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/status.py" line="161"/>
        <source>The image goes to the program that has control.</source>
        <translation>La imagen va al programa que tiene el control.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/status.py" line="163"/>
        <source>The image goes to the program that has control: {0}.</source>
        <translation>La imagen va al programa que tiene el control: {0}.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/status.py" line="53"/>
        <source>Simulated camera</source>
        <translation>Cámara simulada</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/status.py" line="53"/>
        <source>Type an address</source>
        <translation>Escribir dirección</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/status.py" line="53"/>
        <source>Why is mine missing?</source>
        <translation>¿Por qué falta la mía?</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/status.py" line="150"/>
        <source>Choose one of the sources (F8), or begin here:</source>
        <translation>Elija una de las fuentes (F8), o empiece aquí:</translation>
    </message>
</context>
<context>
    <name>StatusStrip</name>
    <message>
        <location filename="../../grabbergui/ui/forms/status_strip.ui" line="17"/>
        <source>State of the connection and of the image</source>
        <translation>Estado de la conexión y de la imagen</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/status_strip.ui" line="18"/>
        <source>Connection</source>
        <translation>Conexión</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/status_strip.ui" line="49"/>
        <source>Resolution and pixel format of the newest frame</source>
        <translation>Resolución y formato de píxel de la última imagen</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/status_strip.ui" line="50"/>
        <source>Resolution and pixel format</source>
        <translation>Resolución y formato de píxel</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/status_strip.ui" line="57"/>
        <source>Frames per second from the camera, and images painted</source>
        <translation>Imágenes por segundo de la cámara y dibujadas</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/status_strip.ui" line="58"/>
        <source>Frame rates</source>
        <translation>Frecuencias</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/status_strip.ui" line="65"/>
        <source>Payload received per second</source>
        <translation>Datos recibidos por segundo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/status_strip.ui" line="66"/>
        <source>Bandwidth</source>
        <translation>Ancho de banda</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/status_strip.ui" line="73"/>
        <source>Lost and incomplete frames, resent packets</source>
        <translation>Imágenes perdidas e incompletas, paquetes reenviados</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/status_strip.ui" line="41"/>
        <source>Samples of the whole frame at the ends of the sensor’s range; a click marks them in the image (X)</source>
        <translation>Muestras de todo el fotograma en los extremos del rango del sensor; un clic las marca en la imagen (X)</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/status_strip.ui" line="88"/>
        <source>Screen pixels for each pixel of the image</source>
        <translation>Píxeles de pantalla por cada píxel de la imagen</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/status_strip.ui" line="89"/>
        <source>Zoom</source>
        <translation>Ampliación</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/widgets/status_strip.py" line="89"/>
        <source>{0} fps · {1} shown</source>
        <translation>{0} fps · {1} mostrados</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/widgets/status_strip.py" line="120"/>
        <source>Clipping</source>
        <translation>Recorte</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/widgets/status_strip.py" line="125"/>
        <source> · fitted</source>
        <translation> · encajada</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/widgets/status_strip.py" line="118"/>
        <source>{0} saturated</source>
        <translation>{0} saturado</translation>
    </message>
</context>
<context>
    <name>StreamHealth</name>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="94"/>
        <source>more arrives than this computer can take</source>
        <translation>llega más de lo que este ordenador puede recibir</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="107"/>
        <source>{0} resent</source>
        <translation>{0} reenviados</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="119"/>
        <source>Frames since the start: {0}, lost {1}, incomplete {2}</source>
        <translation>Imágenes desde el inicio: {0}, perdidas {1}, incompletas {2}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="124"/>
        <source>Frames dropped because they were not taken in time: {0}</source>
        <translation>Imágenes descartadas porque nadie las recogió a tiempo: {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="127"/>
        <source>Packets: {0}, resent {1}, never arrived {2}</source>
        <translation>Paquetes: {0}, reenviados {1}, no llegaron nunca {2}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="97"/>
        <source>1 lost</source>
        <translation>1 perdida</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="97"/>
        <source>{0} lost</source>
        <translation>{0} perdidas</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="98"/>
        <source>1 incomplete</source>
        <translation>1 incompleta</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="98"/>
        <source>{0} incomplete</source>
        <translation>{0} incompletas</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="105"/>
        <source>{0:.1%} resent</source>
        <translation>{0:.1%} reenviado</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="107"/>
        <source>1 resent</source>
        <translation>1 reenviado</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="133"/>
        <source>All waiting packets discarded: {0}×; choose larger packets or a lower frame rate</source>
        <translation>Descartados todos los paquetes en espera: {0}×; elija paquetes más grandes o una frecuencia más baja</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/diagnosis.py" line="130"/>
        <source>Packets refused, as they did not come from the camera: {0}</source>
        <translation>Paquetes rechazados por no venir de la cámara: {0}</translation>
    </message>
</context>
<context>
    <name>TaskRow</name>
    <message>
        <location filename="../../grabbergui/ui/forms/task_row.ui" line="26"/>
        <source>Progress</source>
        <translation>Progreso</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/task_row.ui" line="35"/>
        <source>Cancel</source>
        <translation>Cancelar</translation>
    </message>
</context>
<context>
    <name>Trigger</name>
    <message>
        <location filename="../../grabbergui/models/triggers.py" line="53"/>
        <source>Waiting for trigger</source>
        <translation>Esperando disparo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/triggers.py" line="53"/>
        <source>Trigger on</source>
        <translation>Disparo activado</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/triggers.py" line="60"/>
        <source>Waiting for trigger on {0}</source>
        <translation>Esperando disparo en {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/triggers.py" line="62"/>
        <source>Waiting for trigger from {0}</source>
        <translation>Esperando disparo de {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/triggers.py" line="63"/>
        <source>Trigger: {0}</source>
        <translation>Disparo: {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/triggers.py" line="68"/>
        <source>{0} sent</source>
        <translation>enviados: {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/triggers.py" line="68"/>
        <source>{0} accepted</source>
        <translation>aceptados: {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/triggers.py" line="68"/>
        <source>{0} missed</source>
        <translation>perdidos: {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/triggers.py" line="151"/>
        <source>The trigger failed: {0}</source>
        <translation>Falló el disparo: {0}</translation>
    </message>
</context>
<context>
    <name>TriggerBar</name>
    <message>
        <location filename="../../grabbergui/ui/forms/trigger_bar.ui" line="6"/>
        <source>Trigger</source>
        <translation>Disparo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/trigger_bar.ui" line="18"/>
        <source>What triggers the camera</source>
        <translation>Qué dispara la cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/trigger_bar.ui" line="27"/>
        <source>Triggers sent, accepted and missed</source>
        <translation>Disparos enviados, aceptados y perdidos</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/trigger_bar.ui" line="33"/>
        <source>Send</source>
        <translation>Enviar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/trigger_bar.ui" line="34"/>
        <source>Send one trigger</source>
        <translation>Enviar un disparo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/trigger_bar.ui" line="39"/>
        <source>Repeat every</source>
        <translation>Repetir cada</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/trigger_bar.ui" line="40"/>
        <source>Send triggers again and again, in the distance beside it</source>
        <translation>Enviar disparos repetidamente, con el intervalo de al lado</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/trigger_bar.ui" line="45"/>
        <source>Time between two triggers</source>
        <translation>Tiempo entre dos disparos</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/trigger_bar.ui" line="46"/>
        <source>Time between two triggers that are sent</source>
        <translation>Tiempo entre dos disparos enviados</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/trigger_bar.ui" line="56"/>
        <source>Trigger off</source>
        <translation>Desactivar disparo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/trigger_bar.ui" line="57"/>
        <source>Let the camera run freely</source>
        <translation>Dejar libre la cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/trigger_bar.ui" line="66"/>
        <source>What is wrong with the trigger</source>
        <translation>Qué falla en el disparo</translation>
    </message>
</context>
<context>
    <name>Tuning</name>
    <message>
        <location filename="../../grabbergui/models/tuning.py" line="126"/>
        <source>no frame arrived to measure; start the camera, or its trigger, first</source>
        <translation>no llegó ninguna imagen que medir; inicie antes la cámara o su disparo</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/one_push.py" line="162"/>
        <source>{0} was not done within {1:g} s; does the camera send frames?</source>
        <translation>{0} no terminó en {1:g} s; ¿envía imágenes la cámara?</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/one_push.py" line="164"/>
        <source>{0} at work</source>
        <translation>{0} en marcha</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/one_push.py" line="186"/>
        <source>{0:.0%} of white, aim {1:.0%} · {2}</source>
        <translation>{0:.0%} del blanco, objetivo {1:.0%} · {2}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/one_push.py" line="189"/>
        <source>Exposed: {0:.0%} of white with {1}</source>
        <translation>Expuesto: {0:.0%} del blanco con {1}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/one_push.py" line="121"/>
        <source>cancelled</source>
        <translation>cancelado</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/one_push.py" line="128"/>
        <source>{0}: {1}; not everything could be restored: {2}</source>
        <translation>{0}: {1}; no todo está como antes: {2}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/one_push.py" line="269"/>
        <source>red {0:.0%}, blue {1:.0%} of green</source>
        <translation>rojo {0:.0%}, azul {1:.0%} del verde</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/one_push.py" line="273"/>
        <source>Balanced: {0}</source>
        <translation>Equilibrado: {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/one_push.py" line="275"/>
        <source>As grey as it gets, with {0}; another light would help</source>
        <translation>Todo lo gris que puede ser, con {0}; ayudaría otra luz</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/one_push.py" line="278"/>
        <source>the colour did not settle within {0} steps; is the scene moving, or the lamp flickering?</source>
        <translation>el color no se estabilizó en {0} pasos; ¿se mueve la escena o parpadea la lámpara?</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/one_push.py" line="305"/>
        <source>there is no colour in this pixel format; choose an RGB or a Bayer format first</source>
        <translation>este formato de píxel no tiene color; elija antes uno RGB o Bayer</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/one_push.py" line="311"/>
        <source>{0:.0%} of the region is saturated and has lost its colour; set the exposure first</source>
        <translation>el {0:.0%} de la región está saturado y ha perdido su color; ajuste antes la exposición</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/one_push.py" line="316"/>
        <source>the region is too dark ({0:.1%} of white); set the exposure first</source>
        <translation>la región es demasiado oscura ({0:.1%} del blanco); ajuste antes la exposición</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/one_push.py" line="349"/>
        <source>red {0}, blue {1}</source>
        <translation>rojo {0}, azul {1}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/tuning.py" line="142"/>
        <source>the camera was closed</source>
        <translation>se cerró la cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/tuning.py" line="146"/>
        <source>{0} did not answer within {1:g} s</source>
        <translation>{0} no respondió en {1:g} s</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/one_push.py" line="168"/>
        <source>White balance set by the camera</source>
        <translation>Balance de blancos ajustado por la cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/one_push.py" line="171"/>
        <source>Exposure set by the camera: {0}</source>
        <translation>Exposición ajustada por la cámara: {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/one_push.py" line="194"/>
        <source>the light did not settle within {0} steps (it is at {1:.0%} of white); is the scene moving, or the lamp flickering?</source>
        <translation>la luz no se estabilizó en {0} pasos (está al {1:.0%} del blanco); ¿se mueve la escena o parpadea la lámpara?</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/one_push.py" line="242"/>
        <source>As bright as it gets: {0:.0%} of white instead of {1:.0%}, with {2}; more light, or a lower frame rate, would help</source>
        <translation>Todo lo claro que puede ser: {0:.0%} del blanco en vez de {1:.0%}, con {2}; ayudaría más luz, o una frecuencia más baja</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/one_push.py" line="248"/>
        <source>As dark as it gets: {0:.0%} of white instead of {1:.0%}, with {2}; less light would help</source>
        <translation>Todo lo oscuro que puede ser: {0:.0%} del blanco en vez de {1:.0%}, con {2}; ayudaría menos luz</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/one_push.py" line="319"/>
        <source>the region has hardly any green ({0:.1%} of white), to which red and blue are adjusted; choose a grey one, in another light</source>
        <translation>la región apenas tiene verde ({0:.1%} del blanco), al que se ajustan el rojo y el azul; elija una gris, con otra luz</translation>
    </message>
</context>
<context>
    <name>TuningController</name>
    <message>
        <location filename="../../grabbergui/ui/controllers/tuning.py" line="89"/>
        <source>Exposure</source>
        <translation>Exposición</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/tuning.py" line="94"/>
        <source>White balance</source>
        <translation>Balance de blancos</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/tuning.py" line="110"/>
        <source>Exposure on a region</source>
        <translation>Exposición en una región</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/tuning.py" line="112"/>
        <source>White balance on a region</source>
        <translation>Balance de blancos en una región</translation>
    </message>
</context>
<context>
    <name>Unavailable</name>
    <message>
        <location filename="../../grabbergui/models/unavailable.py" line="14"/>
        <source>No source is open: choose one in the list and connect to it.</source>
        <translation>No hay ninguna fuente abierta: elija una de la lista y conéctela.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/unavailable.py" line="15"/>
        <source>The source is still being opened.</source>
        <translation>La fuente aún se está abriendo.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/unavailable.py" line="16"/>
        <source>The source does not answer: wait until it is back.</source>
        <translation>La fuente no responde: espere a que vuelva.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/unavailable.py" line="17"/>
        <source>The source is stopped: start it first.</source>
        <translation>La fuente está parada: iníciela primero.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/unavailable.py" line="18"/>
        <source>The source is open for reading only: another program controls it.</source>
        <translation>La fuente está abierta solo para lectura: otro programa la controla.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/unavailable.py" line="21"/>
        <source>The source is stopped already.</source>
        <translation>La fuente ya está parada.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/unavailable.py" line="22"/>
        <source>A source is open: disconnect it first, or double-click another one in the list.</source>
        <translation>Hay una fuente abierta: desconéctela primero o haga doble clic en otra de la lista.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/unavailable.py" line="25"/>
        <source>The source is open already: press “Show”, or click its tile.</source>
        <translation>La fuente ya está abierta: pulse «Mostrar» o su miniatura.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/unavailable.py" line="26"/>
        <source>The source streams already.</source>
        <translation>La fuente ya está transmitiendo.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/unavailable.py" line="27"/>
        <source>There is no frame yet: start the camera first.</source>
        <translation>Todavía no hay ninguna imagen: inicie antes la cámara.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/unavailable.py" line="28"/>
        <source>The frame has no range image: enable the component Range, if there is one.</source>
        <translation>La imagen no tiene imagen de distancias: active el componente Range, si lo hay.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/unavailable.py" line="31"/>
        <source>The camera reports no polarisers: if it has some, tick “Sensor has polarisers” below.</source>
        <translation>La cámara no informa de polarizadores: si los tiene, marque «El sensor tiene polarizadores» más abajo.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/unavailable.py" line="34"/>
        <source>The source has neither exposure time nor gain.</source>
        <translation>La fuente no tiene ni tiempo de exposición ni ganancia.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/unavailable.py" line="35"/>
        <source>The source has no white balance.</source>
        <translation>La fuente no tiene balance de blancos.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/unavailable.py" line="36"/>
        <source>The source has no region of interest that can be changed.</source>
        <translation>La fuente no tiene una región de interés que se pueda cambiar.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/unavailable.py" line="37"/>
        <source>The source keeps no user sets: save its settings in a file.</source>
        <translation>La fuente no guarda conjuntos de ajustes: guarde sus ajustes en un archivo.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/unavailable.py" line="40"/>
        <source>The source has no look-up table that can be read.</source>
        <translation>La fuente no tiene una tabla de consulta que se pueda leer.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/unavailable.py" line="41"/>
        <source>The source has no calibration: load one, or calibrate the camera.</source>
        <translation>La fuente no tiene calibración: cargue una o calibre la cámara.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/unavailable.py" line="46"/>
        <source>Nothing was changed since the source was opened.</source>
        <translation>No se ha cambiado nada desde que se abrió la fuente.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/unavailable.py" line="47"/>
        <source>Nothing was undone.</source>
        <translation>No se ha deshecho nada.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/unavailable.py" line="48"/>
        <source>The list is empty.</source>
        <translation>La lista está vacía.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/unavailable.py" line="49"/>
        <source>Wait until the present run has ended.</source>
        <translation>Espere a que termine el ajuste en curso.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/unavailable.py" line="50"/>
        <source>A search is in progress.</source>
        <translation>Hay una búsqueda en curso.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/unavailable.py" line="51"/>
        <source>Choose a source in the list, or type its address above.</source>
        <translation>Elija una fuente de la lista o escriba su dirección arriba.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/unavailable.py" line="52"/>
        <source>The whole image is measured already.</source>
        <translation>Ya se mide la imagen completa.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/unavailable.py" line="53"/>
        <source>Choose a set in the list.</source>
        <translation>Elija un conjunto de la lista.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/unavailable.py" line="54"/>
        <source>This set cannot be changed: choose another one.</source>
        <translation>Este conjunto no se puede cambiar: elija otro.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/unavailable.py" line="55"/>
        <source>The camera starts with this set already, or cannot start with it.</source>
        <translation>La cámara ya arranca con este conjunto, o no puede arrancar con él.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/unavailable.py" line="58"/>
        <source>Nothing was edited.</source>
        <translation>No se ha editado nada.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/unavailable.py" line="59"/>
        <source>This control is the first one already.</source>
        <translation>Este control ya es el primero.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/unavailable.py" line="60"/>
        <source>This control is the last one already.</source>
        <translation>Este control ya es el último.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/unavailable.py" line="61"/>
        <source>This is the first page.</source>
        <translation>Esta es la primera página.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/unavailable.py" line="62"/>
        <source>There are too few views yet.</source>
        <translation>Aún hay muy pocas vistas.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/hand_eye_dialog.py" line="317"/>
        <source>Tick the box above first.</source>
        <translation>Marque antes la casilla de arriba.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/unavailable.py" line="63"/>
        <source>A chessboard has no markers.</source>
        <translation>Un tablero de ajedrez no tiene marcadores.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/hand_eye_dialog.py" line="325"/>
        <source>A single marker has no rows and columns.</source>
        <translation>Un solo marcador no tiene filas ni columnas.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/hand_eye_dialog.py" line="276"/>
        <source>The name is published: stop publishing it first.</source>
        <translation>El nombre está publicado: deje antes de publicarlo.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/servo/ui/servo_window.py" line="286"/>
        <source>Hand and eye of this robot cannot be calibrated here.</source>
        <translation>Aquí no se pueden calibrar mano y ojo de este robot.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/unavailable.py" line="64"/>
        <source>The camera does not offer this now.</source>
        <translation>La cámara no lo ofrece ahora.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/unavailable.py" line="44"/>
        <source>The source is no rig: “New rig…” makes one of several cameras.</source>
        <translation>La fuente no es un grupo: «Nuevo grupo de cámaras…» hace uno de varias cámaras.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/models/unavailable.py" line="45"/>
        <source>The source reports no events.</source>
        <translation>La fuente no comunica eventos.</translation>
    </message>
</context>
<context>
    <name>UserSetsController</name>
    <message>
        <location filename="../../grabbergui/ui/controllers/settings.py" line="264"/>
        <source>Settings kept in the camera</source>
        <translation>Ajustes guardados en la cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/settings.py" line="293"/>
        <source>Loading a set of the camera</source>
        <translation>Cargando un juego de la cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/settings.py" line="297"/>
        <source>Saved the current settings in the camera as {0}</source>
        <translation>Ajustes actuales guardados en la cámara como {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/settings.py" line="298"/>
        <source>Saving in the camera</source>
        <translation>Guardando en la cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/settings.py" line="301"/>
        <source>The camera starts with {0} from its next power-on</source>
        <translation>La cámara arrancará con {0} la próxima vez que se encienda</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/settings.py" line="302"/>
        <source>Writing to the camera</source>
        <translation>Escribiendo en la cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/settings.py" line="288"/>
        <source>1 setting</source>
        <translation>1 ajuste</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/settings.py" line="288"/>
        <source>{0} settings</source>
        <translation>{0} ajustes</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/settings.py" line="289"/>
        <source>Loaded {0}: changed {1}</source>
        <translation>Cargado {0}: ha cambiado {1}</translation>
    </message>
</context>
<context>
    <name>UserSetsDialog</name>
    <message>
        <location filename="../../grabbergui/ui/forms/user_sets_dialog.ui" line="6"/>
        <source>Settings kept in the camera</source>
        <translation>Ajustes guardados en la cámara</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/user_sets_dialog.ui" line="10"/>
        <source>The camera keeps these sets in its own memory, also without power.</source>
        <translation>La propia cámara conserva estos juegos, también sin corriente.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/user_sets_dialog.ui" line="17"/>
        <source>Sets of settings</source>
        <translation>Juegos de ajustes</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/user_sets_dialog.ui" line="27"/>
        <source>Load this set; this can be undone</source>
        <translation>Ajustar la cámara según este juego; se puede deshacer</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/user_sets_dialog.ui" line="28"/>
        <source>&amp;Load</source>
        <translation>&amp;Cargar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/user_sets_dialog.ui" line="34"/>
        <source>Save the current settings in this set, which overwrites it</source>
        <translation>Guardar los ajustes actuales en este juego; lo que contenía se pierde</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/user_sets_dialog.ui" line="35"/>
        <source>&amp;Save here</source>
        <translation>&amp;Guardar aquí</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/user_sets_dialog.ui" line="41"/>
        <source>Let the camera start with this set from its next power-on</source>
        <translation>Que la cámara arranque con este juego la próxima vez que se encienda</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/user_sets_dialog.ui" line="42"/>
        <source>S&amp;tart with this</source>
        <translation>&amp;Arrancar con este</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/user_sets_dialog.ui" line="48"/>
        <source>Close</source>
        <translation>Cerrar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/user_sets_dialog.py" line="66"/>
        <source>{0}  ·  the camera starts with it</source>
        <translation>{0}  ·  la cámara arranca con él</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/user_sets_dialog.py" line="76"/>
        <source>Save the current settings in {0}?</source>
        <translation>¿Guardar los ajustes actuales en {0}?</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/user_sets_dialog.py" line="76"/>
        <source>This overwrites the set and cannot be undone.</source>
        <translation>Lo que contenía se pierde; no se puede deshacer.</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/user_sets_dialog.py" line="82"/>
        <source>Overwrite</source>
        <translation>Sobrescribir</translation>
    </message>
</context>
<context>
    <name>ValueSlider</name>
    <message>
        <location filename="../../grabbergui/ui/editors/value_slider.py" line="205"/>
        <source>{0} … {1}; hold the handle beyond an end to move the range.</source>
        <translation>{0} … {1}; mantenga el control más allá de un extremo para seguir.</translation>
    </message>
</context>
<context>
    <name>ValuesController</name>
    <message>
        <location filename="../../grabbergui/ui/controllers/measuring.py" line="209"/>
        <source>no more than {0} values can be plotted at once; remove one first</source>
        <translation>no se pueden representar más de {0} valores a la vez; quite antes uno</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/measuring.py" line="226"/>
        <source>Saved the values to {0}</source>
        <translation>Valores guardados en {0}</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/measuring.py" line="275"/>
        <source>Save values</source>
        <translation>Guardar valores</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/controllers/measuring.py" line="274"/>
        <source>Comma-separated values (*.csv)</source>
        <translation>Valores separados por comas (*.csv)</translation>
    </message>
</context>
<context>
    <name>ValuesPanel</name>
    <message>
        <location filename="../../grabbergui/ui/forms/values_panel.ui" line="18"/>
        <source>Time span of the plot</source>
        <translation>Cuánto del pasado se muestra</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/values_panel.ui" line="19"/>
        <source>Time shown</source>
        <translation>Tiempo mostrado</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/values_panel.ui" line="21"/>
        <source>Last 10 seconds</source>
        <translation>Últimos 10 segundos</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/values_panel.ui" line="22"/>
        <source>Last minute</source>
        <translation>Último minuto</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/values_panel.ui" line="23"/>
        <source>Last 10 minutes</source>
        <translation>Últimos 10 minutos</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/values_panel.ui" line="24"/>
        <source>Last hour</source>
        <translation>Última hora</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/values_panel.ui" line="35"/>
        <source>Pause reading the values</source>
        <translation>Dejar de leer los valores un rato</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/values_panel.ui" line="36"/>
        <source>Pause</source>
        <translation>Pausa</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/values_panel.ui" line="42"/>
        <source>Save everything that was read as a table of comma-separated values</source>
        <translation>Guardar todo lo leído como tabla de valores separados por comas</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/values_panel.ui" line="43"/>
        <source>Save…</source>
        <translation>Guardar…</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/values_panel.ui" line="48"/>
        <source>Clear the values, and continue</source>
        <translation>Olvidar lo leído y seguir</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/values_panel.ui" line="49"/>
        <source>Clear</source>
        <translation>Vaciar</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/values_panel.ui" line="62"/>
        <source>Right-click a feature and choose “Plot over time”.</source>
        <translation>Pulse un parámetro con el botón derecho y elija «Representar en el tiempo».</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/values_panel.ui" line="56"/>
        <source>Show all curves in one plot, each with a range of its own</source>
        <translation>Superponer todas las curvas, cada una en su propio rango</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/forms/values_panel.ui" line="57"/>
        <source>In one plot</source>
        <translation>En un solo gráfico</translation>
    </message>
    <message>
        <location filename="../../grabbergui/ui/views/measuring_panels.py" line="310"/>
        <source>All curves over time</source>
        <translation>Todas las curvas en el tiempo</translation>
    </message>
</context>
</TS>
