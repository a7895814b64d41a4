"""Makes the report of a camera: one file that a user can attach, and of which `twin:` makes the camera again.

`collect` asks the camera, `computer` this computer; `stand_ins` replaces names, serial numbers and addresses.
The file's format belongs to `driver.twin.report_file`, which reads it too.
"""
