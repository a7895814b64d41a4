from hypothesis import settings

# The machine may be busy; what a test costs is not what is tested.
settings.register_profile("yarp", deadline=None)
settings.load_profile("yarp")
