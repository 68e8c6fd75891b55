"""The messages of the services, made from the schemas in proto/ppnpack/v1 by scripts/python-messages: `pip install ppnpack[client]`."""
