"""What stands between the browser and the page: access, uploads, clicks."""
